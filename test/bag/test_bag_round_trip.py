"""What one reader finds is what was written, for ours, rosbags and mcap alike."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from bag_samples import (
    IMU,
    SHEET,
    START_NS,
    STORE,
    TOPICS,
    TRAJECTORY,
    as_rows,
    expected,
    imus,
    record,
    stamps,
)
from mcap.reader import make_reader
from mcap.records import Channel, Schema
from mcap.stream_reader import StreamReader
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosDurability, QosHistory, QosReliability
from rosbags.rosbag2 import Reader

from qzs_rig.bag import BagReader, BagWriter, TopicSpec


def test_our_reader_gives_the_messages_back_in_log_time_order(bag: Path) -> None:
    with BagReader(bag) as reader:
        assert list(reader.messages()) == expected()


def test_mcap_reads_every_message_with_crcs_on(bag: Path) -> None:
    with (bag / 'bag_0.mcap').open('rb') as file:
        found = [
            (channel.topic, message.log_time, message.data)
            for _, channel, message in make_reader(file, validate_crcs=True).iter_messages()
        ]
    assert sorted(found) == sorted(expected())
    assert [x[1] for x in found] == [x[1] for x in expected()]


def test_publish_time_is_log_time_and_sequence_counts_each_topic(bag: Path) -> None:
    with (bag / 'bag_0.mcap').open('rb') as file:
        messages = [m for _, c, m in make_reader(file).iter_messages(topics=['/top/imu'])]
    assert [m.publish_time for m in messages] == [m.log_time for m in messages]
    assert [m.sequence for m in messages] == list(range(1000))


def test_rosbags_deserialises_what_it_serialised(bag: Path) -> None:
    with AnyReader([bag]) as reader:
        found = [
            (stamp, reader.deserialize(data, connection.msgtype))
            for connection, stamp, data in reader.messages()
            if connection.topic == '/base/imu'
        ]
    assert [stamp for stamp, _ in found] == stamps(1000).tolist()
    for (_, message), data in zip(found, imus(1000, 'base_imu_link'), strict=True):
        assert bytes(STORE.serialize_cdr(message, IMU)) == data


def test_rosbags_reads_metadata_quality_of_service_and_hashes(bag: Path) -> None:
    with Reader(bag) as reader:
        assert reader.message_count == len(expected())
        assert reader.start_time == START_NS
        connections = {x.topic: x for x in reader.connections}
    for spec in TOPICS:
        connection = connections[f'/{spec.name}']
        assert connection.msgtype == spec.msgtype
        assert connection.digest == STORE.hash_rihs01(spec.msgtype)
        (qos,) = connection.ext.offered_qos_profiles
        assert (qos.history, qos.depth) == (QosHistory.KEEP_LAST, spec.depth)
        assert qos.reliability == QosReliability.RELIABLE
        late = QosDurability.TRANSIENT_LOCAL if spec.latched else QosDurability.VOLATILE
        assert qos.durability == late


def test_definitions_are_those_of_the_types(bag: Path) -> None:
    with BagReader(bag) as reader:
        definitions = {x.msgtype: x.definition.decode() for x in reader.channels}
    assert definitions[TRAJECTORY] == STORE.generate_msgdef(TRAJECTORY, ros_version=2)[0]


def test_summary_agrees_with_a_scan_of_the_file(bag: Path) -> None:
    path = bag / 'bag_0.mcap'
    with path.open('rb') as file:
        records = list(StreamReader(file, validate_crcs=True).records)
    with path.open('rb') as file:
        summary = make_reader(file).get_summary()
    assert summary.statistics.message_count == len(expected())
    assert summary.statistics.chunk_count == len(summary.chunk_indexes)
    assert summary.statistics.message_start_time == START_NS
    assert summary.statistics.message_end_time == stamps(1000)[-1]
    assert {x.id: x for x in records if isinstance(x, Schema)} == summary.schemas
    assert {x.id: x for x in records if isinstance(x, Channel)} == summary.channels


def test_message_indexes_point_at_the_messages(bag: Path) -> None:
    """mcap's indexed order relies on them: reversed, it must give the same messages."""
    with (bag / 'bag_0.mcap').open('rb') as file:
        found = [
            (channel.topic, message.log_time, message.data)
            for _, channel, message in make_reader(file).iter_messages(reverse=True)
        ]
    assert sorted(found) == sorted(expected())


def test_rows_are_the_messages_of_a_topic(bag: Path) -> None:
    with BagReader(bag) as reader:
        found = reader.rows('base/imu', IMU)
    assert found.topic == '/base/imu'
    np.testing.assert_array_equal(found.stamps_ns, stamps(1000))
    np.testing.assert_array_equal(found.rows, as_rows(imus(1000, 'base_imu_link')))
    assert found.messages() == list(imus(1000, 'base_imu_link'))


def test_run_sheets_are_parsed_also_in_a_namespace(bag: Path, tmp_path: Path) -> None:
    with BagReader(bag) as reader:
        assert reader.run_sheets() == [SHEET]
        sheet = reader.rows('rig/run').messages()
    with BagWriter(tmp_path / 'b', [TopicSpec('lab/rig/run', 'std_msgs/msg/String')]) as writer:
        writer.write('lab/rig/run', [1], sheet)
    with BagReader(tmp_path / 'b') as reader:
        assert reader.run_sheets() == [SHEET]


def test_a_topic_is_found_in_its_namespace(tmp_path: Path) -> None:
    with BagWriter(tmp_path / 'b', [TopicSpec('/lab/base/imu', IMU)]) as writer:
        writer.write('lab/base/imu', [1], [bytes(12)])
    with BagReader(tmp_path / 'b') as reader:
        assert len(reader.rows('base/imu')) == 1


def test_a_run_folder_and_the_file_are_the_same_bag(bag: Path) -> None:
    for path in (bag.parent, bag, bag / 'bag_0.mcap'):
        with BagReader(path) as reader:
            assert reader.path == bag / 'bag_0.mcap'


def test_the_same_input_gives_the_same_bytes(bag: Path, tmp_path: Path) -> None:
    again = record(tmp_path / 'bag')
    for name in ('bag_0.mcap', 'metadata.yaml'):
        assert (again / name).read_bytes() == (bag / name).read_bytes()


@pytest.mark.parametrize('level', [None, 1, 9])
@pytest.mark.parametrize('chunk_bytes', [100, 5_000, 1 << 20])
def test_chunking_and_compression_change_no_message(
    tmp_path: Path, level: int | None, chunk_bytes: int
) -> None:
    folder = record(tmp_path / 'bag', count=200, level=level, chunk_bytes=chunk_bytes)
    with BagReader(folder) as reader:
        assert list(reader.messages()) == expected(200)
    with AnyReader([folder]) as reader:
        found = [(c.topic, stamp, bytes(data)) for c, stamp, data in reader.messages()]
    assert sorted(found) == sorted(expected(200))


def test_the_ways_to_write_agree(tmp_path: Path) -> None:
    """Rows, messages, single messages, and columns that are not contiguous."""
    messages, at = imus(200, 'base_imu_link'), stamps(200)
    wide = np.repeat(as_rows(messages), 2, axis=1)[:, ::2]
    read = []
    for way in range(4):
        with BagWriter(tmp_path / str(way), [TopicSpec('imu', IMU)]) as bag:
            if way == 0:
                bag.write('imu', at, as_rows(messages))
            elif way == 1:
                bag.write('imu', at, messages)
            elif way == 2:
                for stamp, message in zip(at.tolist(), messages, strict=True):
                    bag.write('imu', [stamp], [message])
            else:
                bag.write('imu', at, wide)
        with BagReader(tmp_path / str(way)) as reader:
            read.append(list(reader.messages()))
    assert read[0] == read[1] == read[2] == read[3]
    assert len(read[0]) == 200


def test_messages_of_mixed_lengths_keep_their_order(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    messages = [bytes([0, 1, 0, 0]) + rng.bytes(int(n)) for n in rng.integers(0, 9, 500)]
    with BagWriter(tmp_path / 'b', [TopicSpec('s', 'std_msgs/msg/String')]) as bag:
        bag.write('s', np.arange(500), messages)
    with BagReader(tmp_path / 'b') as reader:
        assert [m for _, _, m in reader.messages()] == messages
        assert reader.rows('s').messages() == messages
        assert not reader.rows('s').equal


def test_stamps_out_of_order_come_back_sorted_over_all_chunks(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    at = rng.permutation(2000).astype(np.int64) * 1_000_000
    with BagWriter(tmp_path / 'b', [TopicSpec('imu', IMU)], chunk_bytes=3000) as bag:
        rows = np.zeros((2000, 16), dtype=np.uint8)
        rows[:, 4:12] = at[:, None].view(np.uint8)
        for first in range(0, 2000, 50):
            bag.write('imu', at[first : first + 50], rows[first : first + 50])
    with BagReader(tmp_path / 'b') as reader:
        found = reader.rows('imu')
    assert (np.diff(found.stamps_ns) > 0).all()
    np.testing.assert_array_equal(found.rows[:, 4:12].copy().view(np.int64)[:, 0], found.stamps_ns)


def test_an_empty_bag_is_a_bag(tmp_path: Path) -> None:
    with BagWriter(tmp_path / 'b', [TopicSpec('imu', IMU)]):
        pass
    with BagReader(tmp_path / 'b') as reader:
        assert list(reader.messages()) == []
        assert reader.rows('imu').rows.shape == (0, 0)
        assert reader.topics == {'/imu': IMU}
    with Reader(tmp_path / 'b') as reader:
        assert reader.message_count == 0
