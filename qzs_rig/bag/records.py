"""MCAP records that are built or parsed by the thousand (mcap.dev/spec): their bytes, and the
messages of a run of them as arrays over one buffer."""

from __future__ import annotations

import struct
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]
Stamps = NDArray[np.int64]
Offsets = NDArray[np.int64]

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
