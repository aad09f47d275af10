"""What a bag says about a topic: its type with its definition, the offered QoS."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache

from qzs_rig.errors import BagError


@dataclass(frozen=True)
class TopicSpec:
    """A topic to record, with the profile its publisher offers: reliable, keep last `depth`,
    `latched` for late joiners or volatile."""

    name: str
    msgtype: str
    depth: int = 2000
    latched: bool = False


@dataclass(frozen=True)
class Channel:
    """A topic as it stands in a bag: MCAP channel and schema in one."""

    id: int
    topic: str
    msgtype: str
    definition: bytes
    schema_encoding: str = 'ros2msg'
    message_encoding: str = 'cdr'
    metadata: Mapping[str, str] = field(default_factory=dict)

    @property
    def offered_qos(self) -> str:
        """The offered profiles, YAML as rosbag2 writes it; empty when the recorder kept none."""
        return self.metadata.get('offered_qos_profiles', '')

    @property
    def type_hash(self) -> str:
        """RIHS01 hash of the type (REP 2011); empty when the recorder kept none."""
        return self.metadata.get('topic_type_hash', '')


def absolute(topic: str) -> str:
    """The name as rosbag2 writes it: with a leading slash."""
    return '/' + topic.lstrip('/')


def declare(spec: TopicSpec, channel_id: int) -> Channel:
    """The channel of a topic to record; raises BagError for a type nobody knows."""
    definition, type_hash = definition_of(spec.msgtype)
    return Channel(
        id=channel_id,
        topic=absolute(spec.name),
        msgtype=spec.msgtype,
        definition=definition.encode(),
        metadata={'offered_qos_profiles': qos_text(spec), 'topic_type_hash': type_hash},
    )


@lru_cache(maxsize=64)
def definition_of(msgtype: str) -> tuple[str, str]:
    """Full ros2msg definition and RIHS01 hash of a message type of ROS 2 Kilted."""
    from rosbags.typesys import Stores, TypesysError, get_typestore

    store = get_typestore(Stores.ROS2_KILTED)
    try:
        definition, _ = store.generate_msgdef(msgtype, ros_version=2)
        return definition, store.hash_rihs01(msgtype)
    except (TypesysError, KeyError):
        raise BagError(
            f'message type {msgtype!r} is not one of ROS 2 Kilted; '
            'give it as package/msg/Name, for instance sensor_msgs/msg/Imu'
        ) from None


def qos_text(spec: TopicSpec) -> str:
    """The offered profile as rosbag2 writes it (metadata version 9)."""
    durability = 'transient_local' if spec.latched else 'volatile'
    for_ever = '\n    sec: 9223372036\n    nsec: 854775807'
    return (
        f'- history: keep_last\n  depth: {spec.depth}\n'
        f'  reliability: reliable\n  durability: {durability}\n'
        f'  deadline:{for_ever}\n  lifespan:{for_ever}\n'
        f'  liveliness: automatic\n  liveliness_lease_duration:{for_ever}\n'
        '  avoid_ros_namespace_conventions: false'
    )
