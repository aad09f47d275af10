"""Messages gathered into one MCAP chunk without touching them one by one."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

from qzs_rig.bag.records import (
    CHUNK_HEAD,
    MESSAGE_FIELDS,
    MESSAGE_HEAD,
    RECORD_HEAD,
    Bytes,
    Stamps,
    message_record,
)

if TYPE_CHECKING:
    from zstandard import ZstdCompressor

Index = NDArray[np.uint64]


@dataclass(frozen=True)
class EncodedChunk:
    """A chunk record and the message indexes that follow it, ready for the file."""

    start_ns: int
    end_ns: int
    uncompressed_size: int
    compressed_size: int
    compression: str
    chunk: bytes
    indexes: dict[int, bytes]
    counts: dict[int, int]


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

    def encode(self) -> EncodedChunk:
        """The chunk as it goes to the file; the builder keeps its messages until `clear`."""
        records = self._buffer[: self.used].data
        compression, data = self._compress(records)
        indexes = {channel: np.concatenate(parts) for channel, parts in sorted(self._index.items())}
        start_ns = min((int(index[:, 0].min()) for index in indexes.values()), default=0)
        end_ns = max((int(index[:, 0].max()) for index in indexes.values()), default=0)
        head = CHUNK_HEAD.pack(start_ns, end_ns, self.used, zlib.crc32(records))
        name = struct.pack('<I', len(compression)) + compression.encode()
        body = [head, name, struct.pack('<Q', len(data)), data]
        return EncodedChunk(
            start_ns=start_ns,
            end_ns=end_ns,
            uncompressed_size=self.used,
            compressed_size=len(data),
            compression=compression,
            chunk=_record(Opcode.CHUNK, body),
            indexes={channel: _message_index(channel, index) for channel, index in indexes.items()},
            counts={channel: len(index) for channel, index in indexes.items()},
        )

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


def _message_index(channel: int, index: Index) -> bytes:
    return _record(
        Opcode.MESSAGE_INDEX, [struct.pack('<HI', channel, index.nbytes), index.tobytes()]
    )


def _record(opcode: Opcode, body: Sequence[bytes]) -> bytes:
    return b''.join((RECORD_HEAD.pack(opcode, sum(map(len, body))), *body))
