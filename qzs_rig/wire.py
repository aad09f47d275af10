"""Where messages and arrays meet: the topics of the rig and their bytes. No rclpy.

Messages are built and read serialised (CDR): publishers send these bytes as they are and raw
subscriptions deliver them, which is what carries the rig beyond twenty times real time. The two
types that come by the thousand are numpy templates; rosbags serialises all others.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import InputError
from qzs_rig.samples import IMU_CHANNELS, MOTION_CHANNELS, NS, Samples
from qzs_rig.units import DOFS

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

Bytes = NDArray[np.uint8]


class Topic(NamedTuple):
    """A topic of the rig: relative name, type, history depth; `latched` (transient local) for late
    joiners; `watched` for the death of its publisher."""

    name: str
    type: str
    depth: int
    latched: bool = False
    watched: bool = False


# 4000 samples: two seconds of stall at 2 kHz
BASE_MOTION = Topic('base/motion', 'trajectory_msgs/msg/JointTrajectory', 4000)
BASE_IMU = Topic('base/imu', 'sensor_msgs/msg/Imu', 4000)
TOP_IMU = Topic('top/imu', 'sensor_msgs/msg/Imu', 4000)
JOINT_STATES = Topic('joint_states', 'sensor_msgs/msg/JointState', 10)
CLOCK = Topic('/clock', 'rosgraph_msgs/msg/Clock', 10)
RUN = Topic('rig/run', 'std_msgs/msg/String', 10, latched=True, watched=True)
PLATFORM_STATUS = Topic(
    'platform/status', 'diagnostic_msgs/msg/DiagnosticStatus', 1, latched=True, watched=True
)
ANALYZER_STATUS = PLATFORM_STATUS._replace(name='analyzer/status')
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

LITTLE_ENDIAN = 1 << 8
"""The first two bytes of a message, as a number."""

BASE_JOINTS = tuple(f'base_{dof}' for dof in DOFS)
TOP_JOINTS = tuple(f'top_{dof}' for dof in DOFS)
LEVEL = {'ok': 0, 'warn': 1, 'error': 2, 'stale': 3}


def live_topic(dof: str, quantity: str) -> Topic:
    """A plottable Float64 under analyzer/<dof>/: frequency_hz, transmissibility or phase_deg."""
    return Topic(f'analyzer/{dof}/{quantity}', 'std_msgs/msg/Float64', 10)


# --- sensor_msgs/Imu -----------------------------------------------------------------------------


def encode_imu(readings: Samples, frame_id: str) -> Bytes:
    """One message a sample (n, length). Orientation is unreported (covariance -1, REP 145)."""
    layout = _imu_layout(len(frame_id.encode()) + 1)
    rows = np.zeros(len(readings), layout)
    rows['encapsulation'] = LITTLE_ENDIAN
    rows['sec'], rows['nanosec'] = np.divmod(readings.stamps_ns, NS)
    rows['frame_length'] = len(frame_id.encode()) + 1
    rows['frame_id'] = frame_id.encode()
    rows['orientation_covariance'][:, 0] = -1.0
    rows['angular_velocity'] = readings.data[:, :3]
    rows['linear_acceleration'] = readings.data[:, 3:]
    return rows.view(np.uint8).reshape(len(rows), layout.itemsize)


def decode_imu(messages: Sequence[bytes] | Bytes) -> Samples:
    """Readings (n, 6) in serialised Imu messages, from any driver and of any frame_id.

    `messages` is a sequence of bytes or equal rows (n, length). Raises InputError for bytes that
    are no Imu.
    """
    if len(messages) == 0:
        return Samples(np.empty(0, np.int64), np.empty((0, 6)), IMU_CHANNELS)
    if isinstance(messages, np.ndarray):
        return _decode_imu_rows(messages)
    if len(set(map(len, messages))) == 1:
        return _decode_imu_rows(
            np.frombuffer(b''.join(messages), np.uint8).reshape(len(messages), -1)
        )
    return _joined([_decode_imu_rows(np.frombuffer(raw, np.uint8)[None]) for raw in messages])


def _decode_imu_rows(rows: Bytes) -> Samples:
    if rows.shape[1] < 16:
        raise InputError(f'a message of {rows.shape[1]} bytes is no sensor_msgs/msg/Imu')
    lengths = np.ascontiguousarray(rows[:, 12:16]).view('<u4')[:, 0]
    layout = _imu_layout(int(lengths[0])) if lengths[0] < 4096 else None
    if layout is not None and (lengths != lengths[0]).any():
        return _joined([_decode_imu_rows(row[None]) for row in rows])
    if layout is None or rows.shape[1] != layout.itemsize or (rows[:, 1] != 1).any():
        raise InputError(
            f'a message of {rows.shape[1]} bytes is no sensor_msgs/msg/Imu; '
            'check the type of the topic'
        )
    imu = np.ascontiguousarray(rows).view(layout)[:, 0]
    stamps = imu['sec'].astype(np.int64) * NS + imu['nanosec']
    data = np.hstack([imu['angular_velocity'], imu['linear_acceleration']])
    return Samples(stamps, data, IMU_CHANNELS)


def _joined(parts: Sequence[Samples]) -> Samples:
    stamps_ns = np.concatenate([part.stamps_ns for part in parts])
    return Samples(stamps_ns, np.concatenate([part.data for part in parts]), IMU_CHANNELS)


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

# doubles of a point start on a multiple of 8, which puts the next point's length just before them
_POINT = np.dtype(
    {
        'names': ['position', 'n_v', 'velocity', 'n_a', 'acceleration', 'n_e', 'sec', 'ns', 'n_p'],
        'formats': ['(4,)<f8', '<u4', '(4,)<f8', '<u4', '(4,)<f8', '<u4', '<i4', '<u4', '<u4'],
        'offsets': [0, 32, 40, 72, 80, 112, 116, 120, 124],
        'itemsize': 128,
    }
)


def encode_motion(motion: Samples) -> bytes:
    """A JointTrajectory of all samples, at least one."""
    return encode_motions(motion, len(motion)).tobytes()


def encode_motions(motion: Samples, n: int) -> Bytes:
    """Base motion as JointTrajectory messages (m, length) of `n` samples each, which divide it.

    The stamp is that of a message's first sample; each point is due after it at its own.
    """
    stamps, data = motion.stamps_ns.reshape(-1, n), motion.data.reshape(-1, n, len(MOTION_CHANNELS))
    points = np.zeros(stamps.shape, _POINT)
    points['position'], points['velocity'] = data[..., :4], data[..., 4:8]
    points['acceleration'] = data[..., 8:]
    points['n_v'] = points['n_a'] = points['n_p'] = len(DOFS)
    points['sec'], points['ns'] = np.divmod(stamps - stamps[:, :1], NS)
    # no length follows the last point; strict readers refuse trailing bytes
    body = points.view(np.uint8).reshape(len(stamps), n * _POINT.itemsize)[:, :-4]
    head = np.tile(np.frombuffer(_motion_head(n), np.uint8), (len(stamps), 1))
    head[:, 4:12] = np.stack(np.divmod(stamps[:, 0], NS), axis=1).astype('<i4').view(np.uint8)
    return np.concatenate([head, body], axis=1)


def stamp_of(message: bytes) -> int:
    """Stamp in ns of any message that starts with a std_msgs/Header or a stamp."""
    try:
        encapsulation, seconds, nanoseconds = struct.unpack_from('<HxxiI', message)
    except struct.error:
        raise InputError(f'a message of {len(message)} bytes has no stamp') from None
    if encapsulation != LITTLE_ENDIAN:
        raise InputError(
            f'message starts with {bytes(message[:4]).hex()}, not with little-endian CDR; '
            'record it with an XCDR1 middleware'
        )
    return int(seconds) * NS + int(nanoseconds)


def decode_motion(message: bytes) -> Samples:
    """The motion (n, 12) in a serialised JointTrajectory; InputError where it is not the rig's."""
    start_ns = stamp_of(message)
    try:
        _, at = _strings(message, 12, 1)
        (count,) = struct.unpack_from('<I', message, at)
        joints, at = _strings(message, at + 4, min(count, 64))
        (n,) = struct.unpack_from('<I', message, at)
    except struct.error:
        raise InputError(f'base/motion: a message of {len(message)} bytes is torn') from None
    if joints != BASE_JOINTS:
        raise InputError(
            f'base/motion names joints {", ".join(joints) or "none"}; expected '
            f'{", ".join(BASE_JOINTS)}'
        )
    if n == 0:
        return Samples(np.empty(0, np.int64), np.empty((0, 12)), MOTION_CHANNELS)
    first_length = int.from_bytes(message[at + 4 : at + 8], 'little')
    first = at + 8 + -(at + 4) % 8
    # the last point is not followed by a length, and middlewares differ in padding there
    body = message[first : first + n * _POINT.itemsize]
    if n * _POINT.itemsize - len(body) not in (0, 4) or first_length != len(DOFS):
        raise _foreign_motion()
    points = np.frombuffer(body.ljust(n * _POINT.itemsize, b'\x00'), _POINT)
    lengths_fit = (points['n_v'] == 4).all() and (points['n_a'] == 4).all()
    if not lengths_fit or points['n_e'].any() or (points['n_p'][:-1] != 4).any():
        raise _foreign_motion()
    due = points['sec'].astype(np.int64) * NS + points['ns']
    if due[0] != 0 or np.diff(due, n=2).any():
        raise InputError('base/motion: time_from_start must rise in equal steps from 0')
    data = np.hstack([points['position'], points['velocity'], points['acceleration']])
    return Samples(start_ns + due, data, MOTION_CHANNELS)


def _strings(message: bytes, at: int, count: int) -> tuple[tuple[str, ...], int]:
    """`count` strings from byte `at` on, and where the next field of four bytes begins."""
    found = []
    for _ in range(count):
        (length,) = struct.unpack_from('<I', message, at)
        (text,) = struct.unpack_from(f'{min(length, len(message))}s', message, at + 4)
        found.append(text[:-1].decode(errors='replace'))
        at += 4 + length + -length % 4
    return tuple(found), at


@lru_cache(maxsize=64)
def _motion_head(points: int) -> bytes:
    """Everything before the first double of a trajectory, its stamp still 0."""
    empty = _serialised(BASE_MOTION.type, _header(0, 'base_plate'), list(BASE_JOINTS), [])
    head = empty[:-4] + struct.pack('<II', points, len(DOFS))
    return head + bytes(-(len(head) - 4) % 8)


def _foreign_motion() -> InputError:
    return InputError(
        'base/motion: every point needs 4 positions, 4 velocities, 4 accelerations and no effort'
    )


# --- small messages ------------------------------------------------------------------------------


def encode_joint_states(base: Samples, top: Samples) -> bytes:
    """sensor_msgs/JointState of the last sample: the base, and the top (n, 12 or 18) relative to
    it in the four named degrees of freedom."""
    row = base.data[-1]
    relative = top.data[-1, :12] - row
    return _serialised(
        JOINT_STATES.type,
        _header(int(base.stamps_ns[-1]), ''),
        [*BASE_JOINTS, *TOP_JOINTS],
        np.concatenate([row[:4], relative[:4]]),
        np.concatenate([row[4:8], relative[4:8]]),
        np.empty(0),
    )


def encode_clock(stamp_ns: int) -> bytes:
    """rosgraph_msgs/Clock."""
    return _serialised(CLOCK.type, _time(stamp_ns))


def encode_float(value: float) -> bytes:
    """std_msgs/Float64."""
    return _serialised('std_msgs/msg/Float64', float(value))


def encode_json(document: Mapping[str, Any]) -> bytes:
    """std_msgs/String holding a JSON document."""
    return _serialised(RUN.type, json.dumps(document, allow_nan=False))


def decode_json(message: bytes, topic: str = RUN.name) -> dict[str, Any]:
    """The JSON document in a std_msgs/String; raises InputError, naming `topic`, for anything
    else."""
    text = _deserialised(RUN.type, message).data
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
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
    return _serialised(PLATFORM_STATUS.type, *_status_fields(status))


def decode_status(message: bytes) -> Status:
    """The Status in a serialised DiagnosticStatus; raises InputError where it is none."""
    read = _deserialised(PLATFORM_STATUS.type, message)
    values = {pair.key: pair.value for pair in read.values}
    return Status(read.name, read.level, read.message, values)


def encode_diagnostics(stamp_ns: int, status: Status) -> bytes:
    """diagnostic_msgs/DiagnosticArray with one status."""
    one = _message(PLATFORM_STATUS.type, *_status_fields(status))
    return _serialised(DIAGNOSTICS.type, _header(stamp_ns, ''), [one])


def _status_fields(status: Status) -> tuple[Any, ...]:
    pairs = [_message('diagnostic_msgs/msg/KeyValue', *pair) for pair in status.values.items()]
    return status.level, status.name, status.message, 'qzs_rig', pairs


def _time(stamp_ns: int) -> Any:
    return _message('builtin_interfaces/msg/Time', *divmod(stamp_ns, NS))


def _header(stamp_ns: int, frame_id: str) -> Any:
    return _message('std_msgs/msg/Header', _time(stamp_ns), frame_id)


def _message(kind: str, *fields: Any) -> Any:
    return _store().types[kind](*fields)


def _serialised(kind: str, *fields: Any) -> bytes:
    return bytes(_store().serialize_cdr(_message(kind, *fields), kind, little_endian=True))


def _deserialised(kind: str, message: bytes) -> Any:
    from rosbags.serde import SerdeError

    try:
        return _store().deserialize_cdr(message, kind)
    except SerdeError as error:
        raise InputError(f'a message of {len(message)} bytes is no {kind}: {error}') from error


@cache
def _store() -> Typestore:
    """The messages of Kilted; imported when the first one is met."""
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS2_KILTED)
