"""Quality of service of every topic, and the words for an offer that does not fit."""

from __future__ import annotations

from rclpy.duration import Duration
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
    qos_profile_sensor_data,
)

from qzs_rig.wire import Topic

LEASE = Duration(nanoseconds=500_000_000)
"""A node that has not shown life for this long is dead to its peers."""


def reliable(topic: Topic) -> QoSProfile:
    """Reliable and deep enough for the worst stall; latched topics serve late joiners."""
    return QoSProfile(
        reliability=ReliabilityPolicy.RELIABLE,
        history=HistoryPolicy.KEEP_LAST,
        depth=topic.depth,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if topic.latched else DurabilityPolicy.VOLATILE,
    )


def watched(topic: Topic) -> QoSProfile:
    """`reliable`, and the middleware reports within LEASE when the publisher dies."""
    profile = reliable(topic)
    profile.liveliness = LivelinessPolicy.AUTOMATIC
    profile.liveliness_lease_duration = LEASE
    return profile


def latest(topic: Topic) -> QoSProfile:
    """`watched`, and who comes late gets what holds now, not how it came about."""
    profile = watched(topic)
    profile.depth = 1
    return profile


def driver(name: str) -> QoSProfile:
    """What the analyzer asks of somebody else's Imu: 'reliable' or 'sensor_data'."""
    if name == 'sensor_data':
        return QoSProfile(
            reliability=qos_profile_sensor_data.reliability,
            history=HistoryPolicy.KEEP_LAST,
            depth=4000,
            durability=DurabilityPolicy.VOLATILE,
        )
    return QoSProfile(depth=4000, reliability=ReliabilityPolicy.RELIABLE)


def misfit(topic: str, policy: object) -> str:
    """What to say when a publisher and a subscription on `topic` cannot talk."""
    name = getattr(policy, 'name', policy)
    return (
        f'{topic}: the other side offers or asks an incompatible {name}; '
        'set analyzer.qos to sensor_data for a best-effort driver, or change its QoS'
    )
