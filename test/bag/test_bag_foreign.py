"""Bags that other recorders wrote, and files made to do harm."""

from __future__ import annotations

import resource
import sqlite3
import struct
import subprocess
import sys
from pathlib import Path

import pytest
import zstandard
from bag_samples import IMU, STORE, STRING, expected, imus
from mcap.data_stream import RecordBuilder
from mcap.records import Chunk, DataEnd, Footer, Header
from mcap.writer import CompressionType, IndexType, Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as RosbagsWriter
from rosbags.rosbag2.enums import CompressionFormat, CompressionMode

from qzs_rig.bag import BagReader, Limits, info, recover
from qzs_rig.errors import BagError

MAGIC = b'\x89MCAP0\r\n'
TYPES = {'/base/imu': IMU, '/top/imu': IMU, '/rig/run': STRING}
MESSAGES = [x for x in expected(400) if x[0] in TYPES]


def write_mcap(path: Path, **options: object) -> Path:
    with path.open('wb') as file:
        writer = Writer(file, **options)
        writer.start(profile='ros2')
        schemas, ids = {}, {}
        for topic, msgtype in TYPES.items():
            if msgtype not in schemas:
                text, _ = STORE.generate_msgdef(msgtype, ros_version=2)
                schemas[msgtype] = writer.register_schema(msgtype, 'ros2msg', text.encode())
            ids[topic] = writer.register_channel(topic, 'cdr', schemas[msgtype])
        for topic, stamp, message in MESSAGES:
            writer.add_message(ids[topic], stamp, message, stamp)
        writer.finish()
    return path


def write_rosbags(folder: Path, storage: StoragePlugin, mode: CompressionMode) -> Path:
    writer = RosbagsWriter(folder, version=9, storage_plugin=storage)
    if mode != CompressionMode.NONE:
        writer.set_compression(mode, CompressionFormat.ZSTD)
    writer.open()
    connections = {
        topic: writer.add_connection(topic, msgtype, typestore=STORE)
        for topic, msgtype in TYPES.items()
    }
    for topic, stamp, message in MESSAGES:
        writer.write(connections[topic], stamp, message)
    writer.close()
    return folder


MCAP_OPTIONS = [
    {},
    {'compression': CompressionType.LZ4},
    {'compression': CompressionType.NONE, 'chunk_size': 1000},
    {'use_chunking': False},
    {'use_statistics': False, 'repeat_channels': False, 'repeat_schemas': False},
    {'index_types': IndexType.NONE, 'use_summary_offsets': False},
    {'index_types': IndexType.NONE, 'use_statistics': False, 'repeat_channels': False},
    {'enable_crcs': False, 'enable_data_crcs': True},
]


@pytest.mark.parametrize('options', MCAP_OPTIONS, ids=str)
def test_files_of_mcap_are_read_and_recovered(tmp_path: Path, options: dict[str, object]) -> None:
    path = write_mcap(tmp_path / 'foreign.mcap', **options)
    with BagReader(path) as bag:
        assert bag.topics == dict(sorted(TYPES.items()))
        assert list(bag.messages()) == MESSAGES
        assert bag.rows('top/imu').messages() == list(imus(400, 'top_imu_link'))
    report = recover(path, tmp_path / 'out')
    assert not report.bytes_dropped
    with BagReader(tmp_path / 'out') as bag:
        assert list(bag.messages()) == MESSAGES


@pytest.mark.parametrize('options', MCAP_OPTIONS, ids=str)
def test_cut_files_of_mcap_are_recovered(tmp_path: Path, options: dict[str, object]) -> None:
    data = write_mcap(tmp_path / 'foreign.mcap', **options).read_bytes()
    for tenth in range(1, 10):
        cut = tmp_path / f'cut{tenth}.mcap'
        cut.write_bytes(data[: len(data) * tenth // 10])
        recover(cut, tmp_path / f'out{tenth}')
        with BagReader(tmp_path / f'out{tenth}') as bag:
            assert set(bag.messages()) <= set(MESSAGES)
        with pytest.raises(BagError, match='was not closed'):
            BagReader(cut)


@pytest.mark.parametrize('mode', [CompressionMode.NONE, CompressionMode.STORAGE])
def test_mcap_folders_of_rosbags_are_read(tmp_path: Path, mode: CompressionMode) -> None:
    folder = write_rosbags(tmp_path / 'b', StoragePlugin.MCAP, mode)
    with BagReader(folder) as bag:
        assert list(bag.messages()) == MESSAGES
    assert recover(folder, tmp_path / 'out').bytes_dropped == 0


def test_sqlite_folders_of_rosbags_are_read(tmp_path: Path) -> None:
    folder = write_rosbags(tmp_path / 'b', StoragePlugin.SQLITE3, CompressionMode.NONE)
    with BagReader(folder) as bag:
        assert bag.topics == dict(sorted(TYPES.items()))
        assert list(bag.messages()) == MESSAGES
        assert len(bag.rows('base/imu').rows) == 400
    assert info(folder).messages == len(MESSAGES)
    with pytest.raises(BagError, match=r'only \.mcap files can be recovered'):
        recover(folder, tmp_path / 'out')


@pytest.mark.parametrize('mode', [CompressionMode.FILE, CompressionMode.MESSAGE])
def test_compression_of_rosbag2_is_refused_with_a_way_out(
    tmp_path: Path, mode: CompressionMode
) -> None:
    folder = write_rosbags(tmp_path / 'b', StoragePlugin.SQLITE3, mode)
    with pytest.raises(BagError, match=f'compressed by {mode.name.lower()}.*ros2 bag convert'):
        BagReader(folder)


@pytest.mark.parametrize('content', [b'', b'not SQLite' * 100])
def test_a_broken_sqlite_file_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / 'x.db3').write_bytes(content)
    with pytest.raises(BagError, match='is no readable SQLite bag'):
        BagReader(tmp_path / 'x.db3')


def test_a_sqlite_file_with_too_many_topics_is_refused(tmp_path: Path) -> None:
    base = sqlite3.connect(tmp_path / 'x.db3')
    base.execute('CREATE TABLE topics (id, name, type, serialization_format)')
    base.executemany('INSERT INTO topics VALUES (?, "t", "t", "cdr")', [(k,) for k in range(20)])
    base.commit()
    base.close()
    with pytest.raises(BagError, match='more than 10 topics'):
        BagReader(tmp_path / 'x.db3', Limits(channels=10))


def bomb(path: Path, data: bytes, claimed: int, compression: str, repeat: int = 1) -> Path:
    builder = RecordBuilder()
    Header('ros2', 'bomb').write(builder)
    for _ in range(repeat):
        Chunk(compression, data, 2, 1, 0, claimed).write(builder)
    DataEnd(0).write(builder)
    Footer(0, 0, 0).write(builder)
    path.write_bytes(MAGIC + builder.end() + MAGIC)
    return path


def zeros(size: int, *, with_size: bool) -> bytes:
    compressor = zstandard.ZstdCompressor(level=3, write_content_size=with_size)
    if with_size:
        return compressor.compress(bytes(size))
    stream = compressor.compressobj()
    return b''.join([*(stream.compress(bytes(1 << 20)) for _ in range(size >> 20)), stream.flush()])


GIB = 1 << 30


@pytest.mark.parametrize(
    ('with_size', 'claimed', 'reason'),
    [
        (True, GIB, 'above the limit'),
        (False, GIB, 'above the limit'),
        (True, 1000, 'not to the 1000 it claims'),
        (False, 1000, 'zstd: '),
    ],
)
def test_a_bomb_is_refused_before_memory_is_spent(
    tmp_path: Path, with_size: bool, claimed: int, reason: str
) -> None:
    path = bomb(tmp_path / 'x.mcap', zeros(GIB, with_size=with_size), claimed, 'zstd')
    assert path.stat().st_size < 150_000
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(BagError, match=reason if claimed == 1000 else 'would expand|above'):
        BagReader(path)
    report = recover(path, tmp_path / 'out')
    assert not report.messages
    assert report.findings
    # KiB on Linux; a tenth of what the bomb would take
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 100_000


def test_an_lz4_bomb_is_refused(tmp_path: Path) -> None:
    import lz4.frame

    data = lz4.frame.compress(bytes(100 << 20))
    path = bomb(tmp_path / 'x.mcap', data, 1000, 'lz4')
    with pytest.raises(BagError, match='claims 1000 bytes and holds 1001'):
        BagReader(path)


def test_many_chunks_together_are_a_bomb_too(tmp_path: Path) -> None:
    harmless = struct.pack('<BQ', 0x80, (32 << 20) - 9) + bytes((32 << 20) - 9)  # a private record
    data = zstandard.ZstdCompressor(level=3).compress(harmless)
    path = bomb(tmp_path / 'x.mcap', data, 32 << 20, 'zstd', 40)
    with pytest.raises(BagError, match=r'would expand .* raise Limits.expansion'):
        BagReader(path)


@pytest.mark.parametrize(
    ('data', 'compression', 'reason'),
    [
        (b'abc', 'zstd', 'zstd: '),
        (b'not lz4 at all', 'lz4', 'lz4: '),
        (b'abc', 'lz4', 'claims 50 bytes and holds 0'),
        (b'abc', 'snappy', "compression 'snappy' is unknown, known are zstd, lz4"),
        (b'abc', '', 'claims 50 bytes and holds 3'),
        (struct.pack('<BQ', 5, 10**12) + bytes(41), '', 'the record at its byte 0 is garbled'),
    ],
)
def test_chunks_that_cannot_be_expanded_are_named(
    tmp_path: Path, data: bytes, compression: str, reason: str
) -> None:
    path = bomb(tmp_path / 'x.mcap', data, 50, compression)
    with pytest.raises(BagError, match=f'chunk at byte .*{reason}.*qzs-rig bag recover'):
        BagReader(path)


def test_too_many_channels_are_refused(tmp_path: Path) -> None:
    path = write_mcap(tmp_path / 'x.mcap')
    with pytest.raises(BagError, match='more than 2 channels'):
        BagReader(path, Limits(channels=2))


def test_import_takes_no_rosbags_and_no_rclpy() -> None:
    code = 'import sys, qzs_rig.bag; print([x for x in ("rosbags", "rclpy") if x in sys.modules])'
    root = str(Path(__file__).parents[2])
    out = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, check=True, cwd=root
    )
    assert out.stdout.strip() == '[]'
