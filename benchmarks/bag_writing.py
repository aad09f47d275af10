"""Messages per second of the bag writer and reader beside those of mcap and rosbags.

    python benchmarks/bag_writing.py [--samples 120000] [--folder DIR]

Two Imu topics with noisy signals, zstd level 1 (rosbags: its own zstd), one process, one core.
"""

from __future__ import annotations

import argparse
import io
import shutil
import struct
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from unittest import mock

import numpy as np
import zstandard
from mcap.reader import make_reader
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from numpy.typing import NDArray
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as RosbagsWriter
from rosbags.rosbag2.enums import CompressionFormat, CompressionMode
from rosbags.typesys import Stores, get_typestore

from qzs_rig.bag import BagReader, BagWriter, TopicSpec

IMU = 'sensor_msgs/msg/Imu'
TOPICS = {'base/imu': 'base_imu_link', 'top/imu': 'top_imu_link'}
STEP_NS = 2_000_000
CHUNK = 40


def imu_rows(count: int, frame: str, seed: int) -> tuple[NDArray[np.int64], NDArray[np.uint8]]:
    """Stamps and CDR rows of Imu messages with noise of 24 bits in six fields."""
    stamps = np.arange(count, dtype=np.int64) * STEP_NS + 1_700_000_000_000_000_000
    text = frame.encode() + b'\0'
    head = b'\0\1\0\0' + bytes(8) + struct.pack('<I', len(text)) + text
    head += bytes(-(len(head) - 4) % 8)
    template = np.frombuffer(head + bytes(37 * 8), dtype=np.uint8)
    rows = np.tile(template, (count, 1))
    clock = np.stack(np.divmod(stamps, 10**9), axis=1).astype('<u4')
    rows[:, 4:12] = clock.view(np.uint8)
    noise = np.random.default_rng(seed).normal(size=(count, 6)).astype('<f4').astype('<f8')
    first = len(head)
    rows[:, first + 13 * 8 : first + 16 * 8] = noise[:, :3].copy().view(np.uint8)
    rows[:, first + 25 * 8 : first + 28 * 8] = noise[:, 3:].copy().view(np.uint8)
    return stamps, rows


Data = dict[str, tuple[NDArray[np.int64], NDArray[np.uint8]]]


def write_ours(folder: Path, data: Data) -> None:
    with BagWriter(folder, [TopicSpec(topic, IMU) for topic in data]) as bag:
        for first in range(0, len(next(iter(data.values()))[0]), CHUNK):
            for topic, (stamps, rows) in data.items():
                bag.write(topic, stamps[first : first + CHUNK], rows[first : first + CHUNK])


def write_ours_at_once(folder: Path, data: Data) -> None:
    with BagWriter(folder, [TopicSpec(topic, IMU) for topic in data]) as bag:
        for topic, (stamps, rows) in data.items():
            bag.write(topic, stamps, rows)


def write_ours_singly(folder: Path, data: Data) -> None:
    with BagWriter(folder, [TopicSpec(topic, IMU) for topic in data]) as bag:
        for stamp_ns, topic, message in interleaved(data):
            bag.write(topic, [stamp_ns], [message])


def write_mcap(folder: Path, data: Data) -> None:
    folder.mkdir()
    definition, _ = get_typestore(Stores.ROS2_KILTED).generate_msgdef(IMU, ros_version=2)
    level_1 = zstandard.ZstdCompressor(level=1).compress
    with (
        (folder / 'bag.mcap').open('wb') as file,
        mock.patch('mcap.writer.zstandard.compress', level_1),
    ):
        writer = McapWriter(file, compression=CompressionType.ZSTD)
        writer.start(profile='ros2')
        schema = writer.register_schema(IMU, 'ros2msg', definition.encode())
        ids = {topic: writer.register_channel(f'/{topic}', 'cdr', schema) for topic in data}
        for stamp_ns, topic, message in interleaved(data):
            writer.add_message(ids[topic], stamp_ns, message, stamp_ns)
        writer.finish()


def write_rosbags(folder: Path, data: Data) -> None:
    store = get_typestore(Stores.ROS2_KILTED)
    writer = RosbagsWriter(folder, version=9, storage_plugin=StoragePlugin.MCAP)
    writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    writer.open()
    connections = {x: writer.add_connection(f'/{x}', IMU, typestore=store) for x in data}
    for stamp_ns, topic, message in interleaved(data):
        writer.write(connections[topic], stamp_ns, message)
    writer.close()


def interleaved(data: Data) -> list[tuple[int, str, bytes]]:
    """The messages one by one; prepared before the clock starts."""
    key = id(data)
    if key not in PREPARED:
        columns = [
            [(s, topic, row) for s, row in zip(stamps.tolist(), list_of(rows), strict=True)]
            for topic, (stamps, rows) in data.items()
        ]
        PREPARED[key] = [x for pair in zip(*columns, strict=True) for x in pair]
    return PREPARED[key]


PREPARED: dict[int, list[tuple[int, str, bytes]]] = {}


def list_of(rows: NDArray[np.uint8]) -> list[bytes]:
    return [row.tobytes() for row in rows]


def read_ours_rows(folder: Path) -> int:
    with BagReader(folder) as bag:
        return sum(len(bag.rows(topic).rows) for topic in TOPICS)


def read_ours_messages(folder: Path) -> int:
    with BagReader(folder) as bag:
        return sum(1 for _ in bag.messages())


def read_mcap(folder: Path) -> int:
    data = io.BytesIO(next(folder.glob('*.mcap')).read_bytes())
    return sum(1 for _ in make_reader(data, validate_crcs=True).iter_messages())


def read_rosbags(folder: Path) -> int:
    with AnyReader([folder]) as reader:
        return sum(1 for _ in reader.messages())


def timed(action: Callable[[], object], repeat: int) -> float:
    """Seconds of the fastest of some runs."""
    best = float('inf')
    for _ in range(repeat):
        start = time.perf_counter()
        action()
        best = min(best, time.perf_counter() - start)
    return best


def main() -> None:
    """Print one table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--samples', type=int, default=60_000, help='of each of two topics')
    parser.add_argument('--folder', type=Path, help='where to write (default: a temporary one)')
    arguments = parser.parse_args()
    data: Data = {
        topic: imu_rows(arguments.samples, frame, seed)
        for seed, (topic, frame) in enumerate(TOPICS.items())
    }
    interleaved(data)
    total = arguments.samples * len(TOPICS)
    folder = Path(tempfile.mkdtemp(dir=arguments.folder))
    writers = {
        f'ours, rows by {CHUNK}': write_ours,
        'ours, rows at once': write_ours_at_once,
        'ours, singly': write_ours_singly,
        'mcap.writer.Writer': write_mcap,
        'rosbags Writer': write_rosbags,
    }
    rates = {}
    for number, (name, write) in enumerate(writers.items()):

        def once(write: Callable[[Path, Data], None] = write, number: int = number) -> None:
            shutil.rmtree(folder / f'bag{number}', ignore_errors=True)
            write(folder / f'bag{number}', data)

        rates[name] = total / timed(once, 3)
    size = sum(x.stat().st_size for x in (folder / 'bag0').iterdir())
    length = next(iter(data.values()))[1].shape[1]
    print(f'{total} messages of {length} bytes; bag of {size / 1e6:.1f} MB')
    table('write', rates)
    readers = {
        'ours, rows': read_ours_rows,
        'ours, messages': read_ours_messages,
        'mcap, CRCs on': read_mcap,
        'rosbags, AnyReader': read_rosbags,
    }
    ours = folder / 'bag0'
    table(
        'read', {x: total / timed(lambda read=read: read(ours), 3) for x, read in readers.items()}
    )
    shutil.rmtree(folder)


def table(title: str, rates: dict[str, float]) -> None:
    """Messages per second, and how many times faster the first is."""
    first = next(iter(rates.values()))
    for name, rate in rates.items():
        print(f'{title:6} {name:28} {rate:12,.0f} /s  {first / rate:6.1f}')


if __name__ == '__main__':
    main()
