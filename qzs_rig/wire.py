"""Where messages and arrays meet: the topics of the rig and their bytes. No rclpy, no rosbags.

Messages are built and read as serialised CDR: publishers send these bytes as they are and raw
subscriptions deliver them, which is what carries the rig beyond twenty times real time.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from qzs_rig.cdr import CdrReader, CdrWriter
from qzs_rig.errors import InputError
from qzs_rig.samples import NS, Array
from qzs_rig.units import DOFS

Bytes = NDArray[np.uint8]
Stamps = NDArray[np.int64]


@dataclass(frozen=True)
class Topic:
    """A topic of the rig: relative name, type, history depth, transient local or volatile."""

    name: str
    type: str
    depth: int
    latched: bool = False


# 4000 samples: two seconds of stall at 2 kHz
BASE_MOTION = Topic('base/motion', 'trajectory_msgs/msg/JointTrajectory', 4000)
BASE_IMU = Topic('base/imu', 'sensor_msgs/msg/Imu', 4000)
TOP_IMU = Topic('top/imu', 'sensor_msgs/msg/Imu', 4000)
JOINT_STATES = Topic('joint_states', 'sensor_msgs/msg/JointState', 10)
CLOCK = Topic('/clock', 'rosgraph_msgs/msg/Clock', 10)
RUN = Topic('rig/run', 'std_msgs/msg/String', 10, latched=True)
PLATFORM_STATUS = Topic('platform/status', 'diagnostic_msgs/msg/DiagnosticStatus', 1, latched=True)
ANALYZER_STATUS = Topic('analyzer/status', 'diagnostic_msgs/msg/DiagnosticStatus', 1, latched=True)
ESTIMATE = Topic('analyzer/estimate', 'std_msgs/msg/String', 1, latched=True)
THEORY = Topic('theory/branches', 'std_msgs/msg/String', 1, latched=True)
MATCH = Topic('analyzer/match', 'std_msgs/msg/String', 1, latched=True)
DIAGNOSTICS = Topic('/diagnostics', 'diagnostic_msgs/msg/DiagnosticArray', 10)

TOPICS: dict[str, Topic] = {
    topic.name: topic
    for topic in (
        *(BASE_MOTION, BASE_IMU, TOP_IMU, JOINT_STATES, CLOCK, RUN),
        *(PLATFORM_STATUS, ANALYZER_STATUS, ESTIMATE, THEORY, MATCH, DIAGNOSTICS),
    )
}

BASE_JOINTS = tuple(f'base_{dof}' for dof in DOFS)
TOP_JOINTS = tuple(f'top_{dof}' for dof in DOFS)
LEVEL = {'ok': 0, 'warn': 1, 'error': 2, 'stale': 3}


def live_topic(dof: str, quantity: str) -> Topic:
    """A plottable Float64 under analyzer/<dof>/: frequency_hz, transmissibility or phase_deg."""
    return Topic(f'analyzer/{dof}/{quantity}', 'std_msgs/msg/Float64', 10)


# --- sensor_msgs/Imu -----------------------------------------------------------------------------


class ImuBatch(NamedTuple):
    """Stamps (n,) in ns and readings (n, 6) in the order of sensing.imu.IMU_CHANNELS."""

    stamps_ns: Stamps
    data: Array


def encode_imu(stamps_ns: Stamps, data: Array, frame_id: str) -> Bytes:
    """One message a row (n, length). Orientation is unreported (covariance -1, REP 145)."""
    layout = _imu_layout(len(frame_id.encode()) + 1)
    rows = np.zeros(len(stamps_ns), layout)
    rows['encapsulation'] = 1 << 8
    rows['sec'], rows['nanosec'] = stamps_ns // NS, stamps_ns % NS
    rows['frame_length'] = len(frame_id.encode()) + 1
    rows['frame_id'] = frame_id.encode()
    rows['orientation_covariance'][:, 0] = -1.0
    rows['angular_velocity'] = data[:, :3]
    rows['linear_acceleration'] = data[:, 3:]
    return rows.view(np.uint8).reshape(len(rows), layout.itemsize)


def decode_imu(messages: Sequence[bytes] | Bytes) -> ImuBatch:
    """Stamps and readings of serialised Imu messages, from any driver and of any frame_id.

    `messages` is a sequence of bytes or equal rows (n, length). Raises InputError for bytes that
    are no Imu.
    """
    if len(messages) == 0:
        return ImuBatch(np.empty(0, np.int64), np.empty((0, 6)))
    rows = messages if isinstance(messages, np.ndarray) else stack(messages)
    if rows is not None:
        return _decode_imu_rows(rows)
    parts = [_decode_imu_rows(np.frombuffer(raw, np.uint8)[None]) for raw in messages]
    return ImuBatch(
        np.concatenate([part.stamps_ns for part in parts]),
        np.concatenate([part.data for part in parts]),
    )


def stack(messages: Sequence[bytes]) -> Bytes | None:
    """Messages as equal rows (n, length), or None where their lengths differ."""
    length = len(messages[0])
    if any(len(message) != length for message in messages):
        return None
    return np.frombuffer(b''.join(messages), np.uint8).reshape(len(messages), length)


def _decode_imu_rows(rows: Bytes) -> ImuBatch:
    if rows.shape[1] < 16:
        raise InputError(f'a message of {rows.shape[1]} bytes is no sensor_msgs/msg/Imu')
    lengths = np.ascontiguousarray(rows[:, 12:16]).view('<u4')[:, 0]
    layout = _imu_layout(int(lengths[0])) if lengths[0] < 4096 else None
    same_frame = bool((lengths == lengths[0]).all())
    if layout is not None and not same_frame:
        parts = [_decode_imu_rows(row[None]) for row in rows]
        return ImuBatch(*(np.concatenate(column) for column in zip(*parts, strict=True)))
    if layout is None or rows.shape[1] != layout.itemsize or (rows[:, 1] != 1).any():
        raise InputError(
            f'a message of {rows.shape[1]} bytes is no sensor_msgs/msg/Imu; '
            'check the type of the topic'
        )
    imu = np.ascontiguousarray(rows).view(layout)[:, 0]
    stamps = imu['sec'].astype(np.int64) * NS + imu['nanosec']
    return ImuBatch(stamps, np.hstack([imu['angular_velocity'], imu['linear_acceleration']]))


@lru_cache(maxsize=64)
def _imu_layout(frame_length: int) -> np.dtype[np.void]:
    body = 16 + frame_length + -(12 + frame_length) % 8
    sizes = {'orientation': 4, 'orientation_covariance': 9, 'angular_velocity': 3}
    sizes |= {'angular_covariance': 9, 'linear_acceleration': 3, 'linear_covariance': 9}
    names = ['encapsulation', 'sec', 'nanosec', 'frame_length', 'frame_id']
    formats = ['<u4', '<i4', '<u4', '<u4', f'S{frame_length}']
    offsets = [0, 4, 8, 12, 16]
    for name, count in sizes.items():
        names.append(name)
        formats.append(f'({count},)<f8')
        offsets.append(body)
        body += 8 * count
    return np.dtype({'names': names, 'formats': formats, 'offsets': offsets, 'itemsize': body})


# --- trajectory_msgs/JointTrajectory -------------------------------------------------------------


class MotionChunk(NamedTuple):
    """Base motion (n, 12): position, velocity, acceleration of the four degrees of freedom, at
    `start_ns` and every `step_ns` from there (step 0 where the chunk has one sample)."""

    start_ns: int
    step_ns: int
    data: Array


# doubles of a point start on a multiple of 8, which puts the next point's length just before them
_POINT = np.dtype(
    {
        'names': ['position', 'n_v', 'velocity', 'n_a', 'acceleration', 'n_e', 'sec', 'ns', 'n_p'],
        'formats': ['(4,)<f8', '<u4', '(4,)<f8', '<u4', '(4,)<f8', '<u4', '<i4', '<u4', '<u4'],
        'offsets': [0, 32, 40, 72, 80, 112, 116, 120, 124],
        'itemsize': 128,
    }
)


def encode_motion(start_ns: int, step_ns: int, data: Array) -> bytes:
    """A JointTrajectory whose point k is due k * step_ns after the header's stamp."""
    return encode_motions(np.array([start_ns]), step_ns, data[None]).tobytes()


def encode_motions(starts_ns: Stamps, step_ns: int, data: Array) -> Bytes:
    """Many trajectories at once: starts (m,), data (m, n, 12) -> messages (m, length)."""
    m, n = data.shape[:2]
    head = np.frombuffer(_motion_head(n), np.uint8)
    points = np.zeros((m, n), _POINT)
    points['position'], points['velocity'] = data[..., :4], data[..., 4:8]
    points['acceleration'] = data[..., 8:]
    points['n_v'] = points['n_a'] = points['n_p'] = len(DOFS)
    due = np.arange(n, dtype=np.int64) * step_ns
    points['sec'], points['ns'] = due // NS, due % NS
    # no length follows the last point; strict readers refuse trailing bytes
    body = points.view(np.uint8).reshape(m, n * _POINT.itemsize)[:, :-4]
    rows = np.concatenate([np.tile(head, (m, 1)), body], axis=1)
    stamps = np.stack([starts_ns // NS, starts_ns % NS], axis=1)
    rows[:, 4:12] = stamps.astype('<i4').view(np.uint8)
    return rows


def stamp_of(message: bytes) -> int:
    """Stamp in ns of any message that starts with a std_msgs/Header."""
    return CdrReader(message).time()


def decode_motion(message: bytes) -> MotionChunk:
    """The chunk in a serialised JointTrajectory; raises InputError where it is not the rig's."""
    reader = CdrReader(message)
    start_ns = reader.time()
    reader.string()
    joints = tuple(reader.string() for _ in range(min(reader.u32(), 64)))
    if joints != BASE_JOINTS:
        raise InputError(
            f'base/motion names joints {", ".join(joints) or "none"}; expected '
            f'{", ".join(BASE_JOINTS)}'
        )
    n = reader.u32()
    if n == 0:
        return MotionChunk(start_ns, 0, np.empty((0, 12)))
    first_length = reader.u32()
    reader.align(8)
    # the last point is not followed by a length, and middlewares differ in padding there
    body = message[reader.offset : reader.offset + n * _POINT.itemsize]
    if n * _POINT.itemsize - len(body) not in (0, 4) or first_length != len(DOFS):
        raise _foreign_motion()
    points = np.frombuffer(body.ljust(n * _POINT.itemsize, b'\x00'), _POINT)
    lengths_fit = (points['n_v'] == 4).all() and (points['n_a'] == 4).all()
    if not lengths_fit or points['n_e'].any() or (points['n_p'][:-1] != 4).any():
        raise _foreign_motion()
    due = points['sec'].astype(np.int64) * NS + points['ns']
    step_ns = int(due[1] - due[0]) if n > 1 else 0
    if due[0] != 0 or (np.diff(due) != step_ns).any():
        raise InputError('base/motion: time_from_start must rise in equal steps from 0')
    data = np.hstack([points['position'], points['velocity'], points['acceleration']])
    return MotionChunk(start_ns, step_ns, data)


@lru_cache(maxsize=64)
def _motion_head(points: int) -> bytes:
    """Everything before the first double of a trajectory, its stamp still 0."""
    writer = CdrWriter()
    writer.time(0)
    writer.string('base_plate')
    writer.strings(BASE_JOINTS)
    writer.u32(points)
    if points:
        writer.u32(len(DOFS))
        writer.align(8)
    return writer.bytes()


def _foreign_motion() -> InputError:
    return InputError(
        'base/motion: every point needs 4 positions, 4 velocities, 4 accelerations and no effort'
    )


# --- small messages ------------------------------------------------------------------------------


def encode_joint_states(stamp_ns: int, base: Array, top: Array) -> bytes:
    """sensor_msgs/JointState of the base, and of the top relative to it, from motion rows (12,);
    of a coupled top (18,) the four named degrees of freedom."""
    writer = CdrWriter()
    writer.time(stamp_ns)
    writer.string('')
    writer.strings(BASE_JOINTS + TOP_JOINTS)
    relative = top[:12] - base
    writer.f64s([*base[:4].tolist(), *relative[:4].tolist()])
    writer.f64s([*base[4:8].tolist(), *relative[4:8].tolist()])
    writer.f64s([])
    return writer.bytes()


def encode_clock(stamp_ns: int) -> bytes:
    """rosgraph_msgs/Clock."""
    writer = CdrWriter()
    writer.time(stamp_ns)
    return writer.bytes()


def encode_float(value: float) -> bytes:
    """std_msgs/Float64."""
    writer = CdrWriter()
    writer.f64(float(value))
    return writer.bytes()


def encode_json(document: Mapping[str, Any]) -> bytes:
    """std_msgs/String holding a JSON document."""
    writer = CdrWriter()
    writer.string(json.dumps(document, allow_nan=False))
    return writer.bytes()


def decode_json(message: bytes, topic: str = RUN.name) -> dict[str, Any]:
    """The JSON document in a std_msgs/String; raises InputError, naming `topic`, for anything
    else."""
    text = CdrReader(message).string()
    try:
        document = json.loads(text)
    except json.JSONDecodeError as error:
        raise InputError(f'{topic} holds no JSON: {error}') from error
    if not isinstance(document, dict):
        raise InputError(f'{topic} holds a JSON {type(document).__name__}, expected an object')
    return document


@dataclass(frozen=True)
class Status:
    """State of one node: diagnostic_msgs/DiagnosticStatus with its values as text."""

    name: str
    level: int
    message: str
    values: Mapping[str, str]


def encode_status(status: Status) -> bytes:
    """diagnostic_msgs/DiagnosticStatus."""
    writer = CdrWriter()
    _write_status(writer, status)
    return writer.bytes()


def decode_status(message: bytes) -> Status:
    """The Status in a serialised DiagnosticStatus."""
    reader = CdrReader(message)
    level = reader.byte()
    name, text, _ = reader.string(), reader.string(), reader.string()
    pairs = [(reader.string(), reader.string()) for _ in range(reader.u32())]
    return Status(name, level, text, dict(pairs))


def encode_diagnostics(stamp_ns: int, status: Status) -> bytes:
    """diagnostic_msgs/DiagnosticArray with one status."""
    writer = CdrWriter()
    writer.time(stamp_ns)
    writer.string('')
    writer.u32(1)
    _write_status(writer, status)
    return writer.bytes()


def _write_status(writer: CdrWriter, status: Status) -> None:
    writer.byte(status.level)
    writer.string(status.name)
    writer.string(status.message)
    writer.string('qzs_rig')
    writer.u32(len(status.values))
    for key, value in status.values.items():
        writer.string(key)
        writer.string(value)
