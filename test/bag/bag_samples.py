"""Messages of a run, made with rosbags' own serialiser as the independent reference."""

from __future__ import annotations

import json
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_typestore

from qzs_rig.bag import BagWriter, TopicSpec

IMU = 'sensor_msgs/msg/Imu'
STRING = 'std_msgs/msg/String'
TRAJECTORY = 'trajectory_msgs/msg/JointTrajectory'
STORE = get_typestore(Stores.ROS2_KILTED)

START_NS = 1_700_000_000_000_000_000
STEP_NS = 2_000_000
CHUNK = 40
TOPICS = (
    TopicSpec('base/motion', TRAJECTORY),
    TopicSpec('base/imu', IMU),
    TopicSpec('top/imu', IMU),
    TopicSpec('rig/run', STRING, depth=1, latched=True),
)
SHEET = {'schema': 1, 'state': 'running', 'start_ns': START_NS, 'step_ns': STEP_NS}


def cdr(msgtype: str, message: Any) -> bytes:
    return bytes(STORE.serialize_cdr(message, msgtype))


def string(text: str) -> bytes:
    return cdr(STRING, STORE.types[STRING](data=text))


def header(stamp_ns: int, frame: str) -> Any:
    time = STORE.types['builtin_interfaces/msg/Time'](*divmod(stamp_ns, 10**9))
    return STORE.types['std_msgs/msg/Header'](stamp=time, frame_id=frame)


def imu(stamp_ns: int, frame: str, seed: int) -> bytes:
    rng = np.random.default_rng(seed)
    vector = STORE.types['geometry_msgs/msg/Vector3']
    covariance = np.zeros(9)
    return cdr(
        IMU,
        STORE.types[IMU](
            header=header(stamp_ns, frame),
            orientation=STORE.types['geometry_msgs/msg/Quaternion'](0.0, 0.0, 0.0, 1.0),
            orientation_covariance=covariance,
            angular_velocity=vector(*rng.normal(size=3)),
            angular_velocity_covariance=covariance,
            linear_acceleration=vector(*rng.normal(size=3)),
            linear_acceleration_covariance=covariance,
        ),
    )


def trajectory(stamp_ns: int, points: int) -> bytes:
    point = STORE.types['trajectory_msgs/msg/JointTrajectoryPoint']
    duration = STORE.types['builtin_interfaces/msg/Duration']
    values = np.linspace(0.0, 1.0, 4)
    return cdr(
        TRAJECTORY,
        STORE.types[TRAJECTORY](
            header=header(stamp_ns, 'base_plate'),
            joint_names=['a', 'b', 'c', 'd'],
            points=[
                point(values, values, values, np.empty(0), duration(0, k * STEP_NS))
                for k in range(points)
            ],
        ),
    )


@lru_cache(maxsize=4)
def imus(count: int, frame: str) -> tuple[bytes, ...]:
    return tuple(imu(START_NS + k * STEP_NS, frame, k) for k in range(count))


def stamps(count: int) -> np.ndarray:
    return START_NS + STEP_NS * np.arange(count, dtype=np.int64)


def as_rows(messages: tuple[bytes, ...]) -> np.ndarray:
    return np.frombuffer(b''.join(messages), dtype=np.uint8).reshape(len(messages), -1)


def record(folder: Path, count: int = 1000, **options: Any) -> Path:
    """A run of `count` samples as the analyzer records it: chunks of all topics in turn."""
    base, top = imus(count, 'base_imu_link'), imus(count, 'top_imu_link')
    at = stamps(count)
    with BagWriter(folder, TOPICS, clock=lambda: 0.0, **options) as bag:
        bag.write('rig/run', [START_NS], [string(json.dumps(SHEET))])
        for first in range(0, count, CHUNK):
            part = slice(first, first + CHUNK)
            bag.write('base/motion', at[first : first + 1], [trajectory(at[first], CHUNK)])
            bag.write('base/imu', at[part], as_rows(base[part]))
            bag.write('top/imu', at[part], top[part])
    return folder


def expected(count: int = 1000) -> list[tuple[str, int, bytes]]:
    """The messages of `record`, by log time and, where it is equal, as they were written."""
    at = stamps(count).tolist()
    found = [('/rig/run', START_NS, string(json.dumps(SHEET)))]
    for first in range(0, count, CHUNK):
        last = min(first + CHUNK, count)
        found.append(('/base/motion', at[first], trajectory(at[first], CHUNK)))
        for topic, frame in (('/base/imu', 'base_imu_link'), ('/top/imu', 'top_imu_link')):
            messages = imus(count, frame)
            found += [(topic, at[k], messages[k]) for k in range(first, last)]
    return sorted(found, key=lambda message: message[1])
