"""The bytes on the wire: equal to rclpy's own, read by rclpy and by rosbags, and read back."""

from __future__ import annotations

import json
import math
import struct

import numpy as np
import pytest
from builtin_interfaces.msg import Duration, Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from hypothesis import given, settings
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.typesys import Stores, get_typestore
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, JointState
from std_msgs.msg import Float64, Header, String
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from qzs_rig import wire
from qzs_rig.errors import InputError
from qzs_rig.samples import IMU_CHANNELS, MOTION_CHANNELS, Samples
from qzs_rig.units import DOFS
from qzs_rig.wire import Status

NS = 1_000_000_000
START = 1_700_000_000_123_456_789
STORE = get_typestore(Stores.ROS2_KILTED)  # a CDR implementation of its own, in Python
FRAMES = ['', 'a', 'base_imu_link', 'top_imu_link', 'imu', 'Prüfstand/imu', 'x' * 300]
STATUS = Status('platform', 1, 'späte Proben', {'rate': '500', 'lost': '0', 'leer': ''})

finite = st.floats(allow_nan=False)
any_float = st.floats()
stamps = st.integers(0, 2**31 * NS - 1)
texts = st.text(st.characters(codec='utf-8', exclude_characters='\0'), max_size=40)


def read_by_rosbags(message, topic):
    return STORE.deserialize_cdr(bytes(message), topic.type)


def stamp_of(header):
    return header.stamp.sec * NS + getattr(header.stamp, 'nanosec')  # noqa: B009


def readings(n=3, step_ns=1):
    data = np.random.default_rng(7).standard_normal((n, 6)) * 9.81
    return Samples(START + step_ns * np.arange(n), data, IMU_CHANNELS)


def time_of(stamp_ns):
    return Time(sec=stamp_ns // NS, nanosec=stamp_ns % NS)


def imu_message(stamp_ns, row, frame_id):
    imu = Imu(header=Header(stamp=time_of(stamp_ns), frame_id=frame_id))
    imu.orientation.w = 0.0
    imu.orientation_covariance[0] = -1.0
    for part, values in ((imu.angular_velocity, row[:3]), (imu.linear_acceleration, row[3:])):
        part.x, part.y, part.z = (float(value) for value in values)
    return imu


# --- Imu ---


@pytest.mark.parametrize('frame_id', FRAMES, ids=len)
def test_imu_bytes_equal_those_of_rclpy(frame_id):
    samples = readings(step_ns=2_000_000)
    ours = wire.encode_imu(samples, frame_id)
    length = len(frame_id.encode()) + 1
    padding = range(16 + length, 16 + length + -(12 + length) % 8)  # rclpy leaves it as it was
    for row, stamp, reading in zip(ours, samples.stamps_ns.tolist(), samples.data, strict=True):
        theirs = np.frombuffer(serialize_message(imu_message(stamp, reading, frame_id)), np.uint8)
        assert len(theirs) == len(row)
        different = np.flatnonzero(theirs != row)
        assert set(different.tolist()) <= set(padding)
        assert not row[list(padding)].any()


def test_some_frames_need_no_padding():
    assert any((12 + len(frame.encode()) + 1) % 8 == 0 for frame in FRAMES)


@pytest.mark.parametrize('frame_id', FRAMES, ids=len)
def test_imu_is_read_by_rclpy_and_rosbags(frame_id):
    data = readings().data
    rows = wire.encode_imu(readings(), frame_id)
    for k, row in enumerate(rows):
        for imu in (deserialize_message(row.tobytes(), Imu), read_by_rosbags(row, wire.BASE_IMU)):
            assert stamp_of(imu.header) == START + k
            assert imu.header.frame_id == frame_id
            parts = (imu.angular_velocity, imu.linear_acceleration)
            assert [getattr(p, a) for p in parts for a in 'xyz'] == data[k].tolist()
            assert imu.orientation_covariance[0] == -1.0  # REP 145: no orientation
            assert not np.any(imu.angular_velocity_covariance)


@settings(max_examples=50, deadline=None)
@given(
    st.lists(st.tuples(stamps, st.lists(any_float, min_size=6, max_size=6)), max_size=5),
    texts,
)
def test_imu_round_trip(rows, frame_id):
    stamps_ns = np.array([stamp for stamp, _ in rows], np.int64)
    data = np.array([row for _, row in rows], float).reshape(-1, 6)
    encoded = wire.encode_imu(Samples(stamps_ns, data, IMU_CHANNELS), frame_id)
    for messages in (encoded, [row.tobytes() for row in encoded]):
        batch = wire.decode_imu(messages)
        assert batch.stamps_ns.tolist() == stamps_ns.tolist()
        assert batch.data.tobytes() == data.tobytes()
        assert batch.channels == IMU_CHANNELS


@settings(max_examples=30, deadline=None)
@given(st.lists(texts, min_size=1, max_size=6))
def test_foreign_imus_of_mixed_frames_are_decoded(frames):
    data = readings(len(frames)).data
    messages = [
        bytes(serialize_message(imu_message(START + k, data[k], frame)))
        for k, frame in enumerate(frames)
    ]
    batch = wire.decode_imu(messages)
    assert batch.stamps_ns.tolist() == [START + k for k in range(len(frames))]
    assert np.array_equal(batch.data, data)


def test_frames_of_equal_padded_length_are_told_apart():
    # 12 + 10 and 12 + 12 both pad to 24: equal rows, different layouts
    samples = readings(2)
    messages = [
        wire.encode_imu(samples[k : k + 1], frame).tobytes()
        for k, frame in enumerate(('nine_long', 'eleven_long'))
    ]
    assert len(messages[0]) == len(messages[1])
    assert np.array_equal(wire.decode_imu(messages).data, samples.data)


def test_no_messages_are_no_samples():
    batch = wire.decode_imu([])
    assert (batch.stamps_ns.shape, batch.data.shape) == ((0,), (0, 6))


GOOD = wire.encode_imu(readings(1), 'imu').tobytes()


@pytest.mark.parametrize(
    'message',
    [
        b'',
        GOOD[:10],
        GOOD[:15],
        GOOD[:-1],
        GOOD + b'\0',
        b'\0\0' + GOOD[2:],  # big endian
        GOOD[:12] + struct.pack('<I', 9) + GOOD[16:],
        GOOD[:12] + struct.pack('<I', 2**32 - 1) + GOOD[16:],
        bytes(serialize_message(String(data='no Imu, but longer than sixteen bytes'))),
    ],
    ids=range(9),
)
def test_bytes_that_are_no_imu_are_refused(message):
    for messages in ([message], [GOOD, message]):
        with pytest.raises(InputError, match=r'a message of \d+ bytes is no sensor_msgs/msg/Imu'):
            wire.decode_imu(messages)


@settings(max_examples=100, deadline=None)
@given(st.binary(max_size=400))
def test_any_bytes_are_decoded_or_refused(message):
    for decode in (
        lambda raw: wire.decode_imu([raw]),
        wire.decode_motion,
        wire.decode_json,
        wire.decode_status,
        wire.stamp_of,
    ):
        for raw in (message, b'\0\1\0\0' + message):
            try:
                decode(raw)
            except InputError as error:
                assert str(error)


# --- base motion ---


def motion(n):
    return np.random.default_rng(n).standard_normal((n, 12))


def moved(data, step_ns=2_000_000, start_ns=START):
    return Samples(start_ns + step_ns * np.arange(len(data)), data, MOTION_CHANNELS)


def trajectory(start_ns, step_ns, data):
    points = [
        JointTrajectoryPoint(
            positions=row[:4].tolist(),
            velocities=row[4:8].tolist(),
            accelerations=row[8:].tolist(),
            time_from_start=Duration(sec=k * step_ns // NS, nanosec=k * step_ns % NS),
        )
        for k, row in enumerate(data)
    ]
    header = Header(stamp=time_of(start_ns), frame_id='base_plate')
    return JointTrajectory(header=header, joint_names=list(wire.BASE_JOINTS), points=points)


@pytest.mark.parametrize('n', [1, 2, 40])
def test_motion_is_read_by_rclpy_and_rosbags(n):
    data, step_ns = motion(n), 700_000_001
    message = wire.encode_motion(moved(data, step_ns))
    for read in (
        deserialize_message(message, JointTrajectory),
        read_by_rosbags(message, wire.BASE_MOTION),
    ):
        assert stamp_of(read.header) == START
        assert (read.header.frame_id, list(read.joint_names)) == (
            'base_plate',
            [f'base_{dof}' for dof in DOFS],
        )
        assert len(read.points) == n
        for k, point in enumerate(read.points):
            rows = (point.positions, point.velocities, point.accelerations)
            assert np.concatenate([np.asarray(row) for row in rows]).tolist() == data[k].tolist()
            assert len(point.effort) == 0
            due = point.time_from_start
            assert due.sec * NS + due.nanosec == k * step_ns


@pytest.mark.parametrize('n', [0, 1, 2, 40])
@pytest.mark.parametrize('trailing', [b'', b'\0\0\0\0', b'\x7f' * 8])
def test_motion_of_rclpy_is_decoded(n, trailing):
    data = motion(n)
    raw = bytes(serialize_message(trajectory(START, 2_000_000, data))) + trailing
    chunk = wire.decode_motion(raw)
    assert chunk.stamps_ns.tolist() == [START + k * 2_000_000 for k in range(n)]
    assert np.array_equal(chunk.data, data)


@settings(max_examples=40, deadline=None)
@given(stamps, st.integers(1, 10**9), st.integers(1, 6), st.data())
def test_motion_round_trip(start_ns, step_ns, n, draw):
    row = st.lists(any_float, min_size=12, max_size=12)
    data = np.array(draw.draw(st.lists(row, min_size=n, max_size=n))).reshape(n, 12)
    chunk = wire.decode_motion(wire.encode_motion(moved(data, step_ns, start_ns)))
    assert chunk.stamps_ns.tolist() == [start_ns + k * step_ns for k in range(n)]
    assert chunk.channels == MOTION_CHANNELS
    assert chunk.data.tobytes() == data.tobytes()


def test_many_motions_at_once_are_the_single_ones():
    whole = moved(motion(12))
    single = [wire.encode_motion(whole[first : first + 4]) for first in (0, 4, 8)]
    assert [row.tobytes() for row in wire.encode_motions(whole, 4)] == single
    assert [wire.stamp_of(message) for message in single] == whole.stamps_ns[::4].tolist()


def altered(change):
    message = trajectory(START, 2_000_000, motion(3))
    change(message)
    return bytes(serialize_message(message))


FOREIGN = 'every point needs 4 positions, 4 velocities, 4 accelerations and no effort'


@pytest.mark.parametrize(
    ('change', 'message'),
    [
        (lambda m: m.joint_names.clear(), 'names joints none; expected base_vertical'),
        (lambda m: m.joint_names.reverse(), 'names joints base_horizontal_rotation, .*; expected'),
        (lambda m: m.points[0].positions.pop(), FOREIGN),
        (lambda m: m.points[1].velocities.pop(), FOREIGN),
        (lambda m: m.points[2].accelerations.pop(), FOREIGN),
        (lambda m: m.points[0].effort.append(1.0), FOREIGN),
        (lambda m: m.points[2].effort.append(1.0), FOREIGN),
        (lambda m: setattr(m.points[0].time_from_start, 'nanosec', 1), 'equal steps from 0'),
        (lambda m: setattr(m.points[2].time_from_start, 'nanosec', 1), 'equal steps from 0'),
    ],
    ids=range(9),
)
def test_a_motion_that_is_not_the_rigs_is_refused(change, message):
    with pytest.raises(InputError, match=f'base/motion.*{message}'):
        wire.decode_motion(altered(change))


def test_a_torn_motion_is_refused():
    whole = wire.encode_motion(moved(motion(3)))
    for length in range(len(whole) - 4):
        with pytest.raises(InputError):
            wire.decode_motion(whole[:length])


# --- small messages ---


@pytest.mark.parametrize('value', [0.0, -1.5, 1e300, math.inf, math.nan])
def test_float_bytes_equal_those_of_rclpy(value):
    ours = wire.encode_float(value)
    assert ours == bytes(serialize_message(Float64(data=value)))
    topic = wire.live_topic('vertical', 'phase_deg')
    assert topic.name == 'analyzer/vertical/phase_deg'
    assert np.array_equal(read_by_rosbags(ours, topic).data, value, equal_nan=True)


def test_float_takes_any_number():
    assert wire.encode_float(1) == wire.encode_float(np.float32(1.0)) == wire.encode_float(1.0)


@pytest.mark.parametrize('stamp_ns', [0, 1, START, 2**31 * NS - 1])
def test_clock_bytes_equal_those_of_rclpy(stamp_ns):
    ours = wire.encode_clock(stamp_ns)
    assert ours == bytes(serialize_message(Clock(clock=time_of(stamp_ns))))
    assert wire.stamp_of(ours) == stamp_ns


documents = st.dictionaries(texts, st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False)
    | texts,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(texts, inner, max_size=3),
    max_leaves=5,
), max_size=4)  # fmt: skip


@settings(max_examples=50, deadline=None)
@given(documents)
def test_json_bytes_equal_those_of_rclpy_and_come_back(document):
    ours = wire.encode_json(document)
    assert ours == bytes(serialize_message(String(data=json.dumps(document))))
    assert wire.decode_json(ours) == document
    assert json.loads(read_by_rosbags(ours, wire.RUN).data) == document


def test_json_has_no_nan():
    with pytest.raises(ValueError, match='not JSON compliant'):
        wire.encode_json({'value': math.nan})


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('{"a": ', 'rig/run holds no JSON: Expecting value'),
        ('', 'rig/run holds no JSON'),
        ('[1]', 'rig/run holds a JSON list, expected an object'),
        ('"text"', 'rig/run holds a JSON str'),
    ],
)
def test_a_string_that_is_no_document_is_refused(text, message):
    with pytest.raises(InputError, match=message):
        wire.decode_json(bytes(serialize_message(String(data=text))))
    with pytest.raises(InputError, match=message.replace('rig/run', 'theory/branches')):
        wire.decode_json(bytes(serialize_message(String(data=text))), wire.THEORY.name)


def test_joint_states_are_read_by_rclpy_and_rosbags():
    base, top = motion(2)
    samples = [moved(np.array([0 * row, row]), 2_000_000, START - 2_000_000) for row in (base, top)]
    message = wire.encode_joint_states(*samples)
    for read in (
        deserialize_message(message, JointState),
        read_by_rosbags(message, wire.JOINT_STATES),
    ):
        assert stamp_of(read.header) == START
        assert list(read.name) == [f'{plate}_{dof}' for plate in ('base', 'top') for dof in DOFS]
        assert list(read.position) == [*base[:4], *(top - base)[:4]]
        assert list(read.velocity) == [*base[4:8], *(top - base)[4:8]]
        assert len(read.effort) == 0


def pairs(status):
    return {pair.key: pair.value for pair in status.values}


def assert_status(read):
    level = read.level[0] if isinstance(read.level, bytes) else read.level
    assert (read.name, level, read.message) == (STATUS.name, STATUS.level, STATUS.message)
    assert pairs(read) == STATUS.values


def test_a_status_is_read_by_rclpy_and_rosbags():
    message = wire.encode_status(STATUS)
    assert_status(deserialize_message(message, DiagnosticStatus))
    assert_status(read_by_rosbags(message, wire.PLATFORM_STATUS))


def test_diagnostics_are_read_by_rclpy_and_rosbags():
    message = wire.encode_diagnostics(START, STATUS)
    for read in (
        deserialize_message(message, DiagnosticArray),
        read_by_rosbags(message, wire.DIAGNOSTICS),
    ):
        assert stamp_of(read.header) == START
        assert len(read.status) == 1
        assert_status(read.status[0])


def test_a_status_of_rclpy_is_decoded():
    foreign = DiagnosticStatus(
        level=bytes([STATUS.level]),
        name=STATUS.name,
        message=STATUS.message,
        hardware_id='elsewhere',
        values=[KeyValue(key=key, value=value) for key, value in STATUS.values.items()],
    )
    assert wire.decode_status(bytes(serialize_message(foreign))) == STATUS


@settings(max_examples=50, deadline=None)
@given(texts, st.sampled_from(sorted(wire.LEVEL.values())), texts, st.dictionaries(texts, texts))
def test_status_round_trip(name, level, text, values):
    status = Status(name, level, text, values)
    assert wire.decode_status(wire.encode_status(status)) == status


def test_levels_are_those_of_the_message():
    for name, level in wire.LEVEL.items():
        assert bytes([level]) == getattr(DiagnosticStatus, name.upper())


def test_topics_are_types_of_kilted():
    for name, topic in wire.TOPICS.items():
        assert topic.name == name
        assert topic.type in STORE.types
        assert topic.depth > 0


@pytest.mark.parametrize('message', [b'', b'\0\1', b'\0\0\0\0abcdefgh', b'\0\7\0\0abcdefgh'])
def test_a_stamp_is_of_little_endian_cdr(message):
    with pytest.raises(InputError, match=r'has no stamp|not with little-endian CDR'):
        wire.stamp_of(message)


def test_a_message_that_runs_out_names_its_type():
    with pytest.raises(InputError, match=r'a message of \d+ bytes is no std_msgs/msg/String'):
        wire.decode_json(wire.encode_json({'twelve': 'bytes'})[:-4])
