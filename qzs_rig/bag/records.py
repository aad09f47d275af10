"""MCAP records that are built or parsed by the thousand (mcap.dev/spec): their bytes, the messages
of a run of them as arrays over one buffer, and chunks of them."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from mcap.opcode import Opcode
from mcap.records import ChunkIndex
from numpy.typing import NDArray

if TYPE_CHECKING:
    from zstandard import ZstdCompressor

Bytes = NDArray[np.uint8]
Stamps = NDArray[np.int64]
Offsets = NDArray[np.int64]
Index = NDArray[np.uint64]

MAGIC = b'\x89MCAP0\r\n'

RECORD_HEAD = struct.Struct('<BQ')
"""Opcode, length of what follows."""

CHUNK_HEAD = struct.Struct('<QQQI')
"""First log time, last log time, uncompressed size, CRC-32 of the uncompressed records."""

MESSAGE_HEAD = np.dtype(
    [
        ('opcode', 'u1'),
        ('length', '<u8'),
        ('channel', '<u2'),
        ('sequence', '<u4'),
        ('log_time', '<u8'),
        ('publish_time', '<u8'),
    ]
)

MESSAGE_FIELDS = MESSAGE_HEAD.itemsize - RECORD_HEAD.size
"""Bytes of a message record between its head and its payload: 22."""


@lru_cache(maxsize=64)
def message_record(payload: int) -> np.dtype[Any]:
    """One whole message record with `payload` bytes, packed."""
    return np.dtype([*MESSAGE_HEAD.descr, ('payload', f'V{payload}')])


SCALAR_RUN = 4
"""Equal records seen one by one before numpy looks ahead: below, its calls cost more."""


@dataclass(frozen=True)
class MessageBlock:
    """n messages in `data`: channel, log time, first byte and length of the payload, each (n,)."""

    data: Bytes
    channels: NDArray[np.uint16]
    stamps_ns: Stamps
    starts: Offsets
    lengths: Offsets

    def __len__(self) -> int:
        return len(self.starts)

    @property
    def records(self) -> Offsets:
        """First byte of each message record."""
        return self.starts - MESSAGE_HEAD.itemsize

    def select(self, mask: NDArray[np.bool_] | Offsets) -> MessageBlock:
        """Some of the messages (a mask, or indices in the wanted order) over the same data."""
        return MessageBlock(
            self.data,
            self.channels[mask],
            self.stamps_ns[mask],
            self.starts[mask],
            self.lengths[mask],
        )

    def payloads(self) -> list[bytes]:
        """The messages one by one."""
        buffer = self.data.tobytes()
        bounds = zip(self.starts.tolist(), (self.starts + self.lengths).tolist(), strict=True)
        return [buffer[start:end] for start, end in bounds]

    def packed(self) -> Bytes:
        """All payloads one after the other, in one array."""
        length = int(self.lengths[0]) if len(self) else 0
        if length and (self.lengths == length).all():
            rows: Bytes = windows(self.data, length)[self.starts]
            return rows.reshape(-1)
        return np.frombuffer(b''.join(self.payloads()), dtype=np.uint8)

    def repacked(self) -> MessageBlock:
        """The same messages over a buffer that holds their records and no others."""
        sizes = self.lengths + MESSAGE_HEAD.itemsize
        if sizes.sum() == len(self.data):
            return self
        buffer = self.data.tobytes()
        bounds = zip(self.records.tolist(), (self.starts + self.lengths).tolist(), strict=True)
        joined = b''.join(buffer[start:end] for start, end in bounds)
        return replace(
            self,
            data=np.frombuffer(joined, dtype=np.uint8),
            starts=np.cumsum(sizes) - sizes + MESSAGE_HEAD.itemsize,
        )


@dataclass(frozen=True)
class ParsedRecords:
    """The messages of a buffer, its other records as (opcode, start, end) of their content, and
    `end`: the first byte that no complete record covers."""

    messages: MessageBlock
    others: list[tuple[int, int, int]]
    end: int


def windows(data: Bytes, size: int) -> Bytes:
    """Every run of `size` bytes of `data`, as a view (len(data) - size + 1, size)."""
    data = np.ascontiguousarray(data)
    shape = (len(data) - size + 1, size)
    view: Bytes = np.ndarray(shape, np.uint8, buffer=data, strides=(1, 1))
    return view


def parse_records(data: Bytes, stop: frozenset[int] = frozenset()) -> ParsedRecords:
    """Walk the records of `data` until one is incomplete, malformed or of an opcode in `stop`."""
    buffer = data.tobytes()
    runs: list[tuple[int, int, int]] = []
    others: list[tuple[int, int, int]] = []
    at, size = 0, len(buffer)
    while at + RECORD_HEAD.size <= size:
        opcode, length = RECORD_HEAD.unpack_from(buffer, at)
        start = at + RECORD_HEAD.size
        if start + length > size or opcode in stop or opcode == 0:
            break
        if opcode != Opcode.MESSAGE:
            others.append((opcode, start, start + length))
            at = start + length
            continue
        if length < MESSAGE_FIELDS:
            break
        count = _equal_run(data, buffer, at, length)
        runs.append((at, length, count))
        at += count * (RECORD_HEAD.size + length)
    return ParsedRecords(_block(data, runs), others, at)


def _equal_run(data: Bytes, buffer: bytes, at: int, length: int) -> int:
    """How many message records of `length` follow one another from `at` on, at least one."""
    stride = RECORD_HEAD.size + length
    fit = (len(buffer) - at) // stride
    head = buffer[at : at + RECORD_HEAD.size]
    for count in range(1, min(SCALAR_RUN, fit)):
        if not buffer.startswith(head, at + count * stride):
            return count
    count, window = min(SCALAR_RUN, fit), 32
    wanted = np.frombuffer(head, dtype=np.uint8)
    while count < fit:
        ahead = min(window, fit - count)
        first = at + count * stride
        heads = data[first : first + ahead * stride].reshape(ahead, stride)[:, : RECORD_HEAD.size]
        same = (heads == wanted).all(axis=1)
        if not same.all():
            return count + int(np.argmin(same))
        count, window = count + ahead, window * 4
    return count


def _block(data: Bytes, runs: list[tuple[int, int, int]]) -> MessageBlock:
    """The messages of runs (first byte, record length, count)."""
    table = np.array(runs, dtype=np.int64).reshape(-1, 3)
    first, length, count = table[:, 0], table[:, 1], table[:, 2]
    total = int(count.sum())
    place = np.arange(total) - np.repeat(np.cumsum(count) - count, count)
    lengths = np.repeat(length, count)
    records = np.repeat(first, count) + place * (lengths + RECORD_HEAD.size)
    heads = np.empty(0, dtype=MESSAGE_HEAD)
    if total:
        heads = windows(data, MESSAGE_HEAD.itemsize)[records].view(MESSAGE_HEAD)[:, 0]
    return MessageBlock(
        data=data,
        channels=heads['channel'].astype(np.uint16),
        stamps_ns=heads['log_time'].astype(np.int64),
        starts=records + MESSAGE_HEAD.itemsize,
        lengths=lengths - MESSAGE_FIELDS,
    )


class ChunkBuilder:
    """Messages in the order they came, any mix of channels; read back sorted by their index."""

    def __init__(self, capacity: int, level: int | None) -> None:
        """`level` of zstd, None for no compression; a message above `capacity` bytes still fits."""
        self._buffer: Bytes = np.empty(capacity, dtype=np.uint8)
        self._level = level
        self._compressor: ZstdCompressor | None = None
        self._index: dict[int, list[Index]] = {}
        self.used = 0

    def room(self, payload: int) -> int:
        """How many more messages of `payload` bytes fit; an empty chunk takes at least one."""
        room = (len(self._buffer) - self.used) // (MESSAGE_HEAD.itemsize + payload)
        return max(room, 0 if self.used else 1)

    def append_rows(self, channel: int, sequence: int, stamps_ns: Stamps, rows: Bytes) -> None:
        """Messages of one length (n, length), numbered from `sequence`."""
        count, payload = rows.shape
        layout = message_record(payload)
        records = self._take(count * layout.itemsize).view(layout)
        records['opcode'] = int(Opcode.MESSAGE)
        records['length'] = MESSAGE_FIELDS + payload
        records['channel'] = channel
        records['sequence'] = np.arange(sequence, sequence + count) & 0xFFFFFFFF
        records['log_time'] = stamps_ns
        records['publish_time'] = stamps_ns
        records['payload'] = np.ascontiguousarray(rows).view(f'V{payload}')[:, 0]
        starts = self.used + np.arange(count, dtype=np.int64) * layout.itemsize
        self._note(channel, stamps_ns, starts)
        self.used += count * layout.itemsize

    def append_records(
        self,
        records: Bytes,
        channels: NDArray[np.uint16],
        stamps_ns: Stamps,
        starts: NDArray[np.int64],
    ) -> None:
        """Whole records as they are; message k of `channels` starts at byte `starts` of them."""
        self._take(len(records))[:] = records
        for channel in np.unique(channels):
            mine = channels == channel
            self._note(int(channel), stamps_ns[mine], self.used + starts[mine])
        self.used += len(records)

    @property
    def counts(self) -> dict[int, int]:
        """Messages of each channel."""
        return {channel: sum(map(len, parts)) for channel, parts in self._index.items()}

    def encode(self, offset: int) -> tuple[bytes, ChunkIndex]:
        """The chunk and its message indexes as they go to byte `offset` of the file, and what the
        summary says of them; the builder keeps its messages until `clear`."""
        records = self._buffer[: self.used].data
        compression, data = self._compress(records)
        indexes = {channel: np.concatenate(parts) for channel, parts in sorted(self._index.items())}
        stamps = np.concatenate([index[:, 0] for index in indexes.values()])
        start_ns, end_ns = int(stamps.min()), int(stamps.max())
        head = CHUNK_HEAD.pack(start_ns, end_ns, self.used, zlib.crc32(records))
        name = struct.pack('<I', len(compression)) + compression.encode()
        parts = [_record(Opcode.CHUNK, [head, name, struct.pack('<Q', len(data)), data])]
        offsets, end = {}, offset + len(parts[0])
        for channel, index in indexes.items():
            offsets[channel] = end
            body = [struct.pack('<HI', channel, index.nbytes), index.tobytes()]
            parts.append(_record(Opcode.MESSAGE_INDEX, body))
            end += len(parts[-1])
        chunk = ChunkIndex(
            chunk_length=len(parts[0]),
            chunk_start_offset=offset,
            compression=compression,
            compressed_size=len(data),
            message_end_time=end_ns,
            message_index_length=end - offset - len(parts[0]),
            message_index_offsets=offsets,
            message_start_time=start_ns,
            uncompressed_size=self.used,
        )
        return b''.join(parts), chunk

    def clear(self) -> None:
        """Start the next chunk."""
        self._index = {}
        self.used = 0

    def _take(self, size: int) -> Bytes:
        if self.used + size > len(self._buffer):
            larger = np.empty(self.used + size, dtype=np.uint8)
            larger[: self.used] = self._buffer[: self.used]
            self._buffer = larger
        return self._buffer[self.used : self.used + size]

    def _note(self, channel: int, stamps_ns: Stamps, starts: NDArray[np.int64]) -> None:
        index = np.empty((len(starts), 2), dtype='<u8')
        index[:, 0] = stamps_ns
        index[:, 1] = starts
        self._index.setdefault(channel, []).append(index)

    def _compress(self, records: memoryview) -> tuple[str, bytes]:
        if self._level is None:
            return '', bytes(records)
        if self._compressor is None:
            from zstandard import ZstdCompressor

            self._compressor = ZstdCompressor(level=self._level)
        return 'zstd', self._compressor.compress(records)


def _record(opcode: Opcode, body: Sequence[bytes]) -> bytes:
    return b''.join((RECORD_HEAD.pack(opcode, sum(map(len, body))), *body))
