"""An MCAP file under way: whole chunks go to the system at once, the summary at the end."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterable, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel as ChannelRecord,
)
from mcap.records import (
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from numpy.typing import NDArray

from qzs_rig.bag.folder import Channel, metadata_text, save_metadata
from qzs_rig.bag.records import (
    CHUNK_HEAD,
    MAGIC,
    MESSAGE_FIELDS,
    MESSAGE_HEAD,
    RECORD_HEAD,
    Bytes,
    MessageBlock,
    Stamps,
    message_record,
)

if TYPE_CHECKING:
    from zstandard import ZstdCompressor

Index = NDArray[np.uint64]


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


class McapFile:
    """What reached the file is complete up to `end`; pending messages wait in the open chunk."""

    def __init__(self, folder: Path, *, level: int | None, chunk_bytes: int) -> None:
        """Create `<folder>/<folder name>_0.mcap`; raises FileExistsError where there is one."""
        self.path = path = folder / f'{folder.resolve().name}_0.mcap'
        self.channels: dict[int, Channel] = {}
        self.counts: dict[int, int] = {}
        self.start_ns: int | None = None
        self.end_ns: int | None = None
        self.end = 0
        self._pending = ChunkBuilder(chunk_bytes, level)
        self._numbered: dict[int, int] = {}
        self._chunks: list[ChunkIndex] = []
        self._raw = path.open('xb', buffering=0)

    @property
    def messages(self) -> int:
        """Messages that reached the file."""
        return sum(self.counts.values())

    def begin(self, channels: Iterable[Channel]) -> None:
        """Magic, header and the channels known so far, in one write; a metadata.yaml."""
        header = Header(profile='ros2', library=f'qzs_rig mcap/{version("mcap")}')
        self._put(MAGIC + encode([header, *self._declare(channels)]))
        save_metadata(self.path.parent, self._information())

    def add_channels(self, channels: Iterable[Channel]) -> None:
        """Channels met later; the open chunk is closed first."""
        records = self._declare(channels)
        if records:
            self.flush()
            self._put(encode(records))

    def append_rows(self, channel: int, stamps_ns: Stamps, rows: Bytes) -> None:
        """Messages of one length (n, length); full chunks go to the file on the way."""
        first = 0
        while first < len(rows):
            last = first + self._pending.room(rows.shape[1])
            if last == first:
                self.flush()
                continue
            number = self._numbered[channel]
            part = rows[first:last]
            self._pending.append_rows(channel, number, stamps_ns[first:last], part)
            self._numbered[channel] = number + len(part)
            first = last

    def append_block(self, block: MessageBlock) -> None:
        """The records of a block as they are, in a chunk of their own."""
        self.flush()
        self._pending.append_records(block.data, block.channels, block.stamps_ns, block.records)
        self.flush()

    def flush(self) -> None:
        """Close the open chunk and hand it to the system."""
        if not self._pending.used:
            return
        data, chunk = self._pending.encode(self.end)
        self._put(data)
        self._chunks.append(chunk)
        for channel, count in self._pending.counts.items():
            self.counts[channel] += count
        first, last = chunk.message_start_time, chunk.message_end_time
        self.start_ns = first if self.start_ns is None else min(self.start_ns, first)
        self.end_ns = last if self.end_ns is None else max(self.end_ns, last)
        self._pending.clear()

    def finish(self) -> None:
        """The rosbag2 metadata, the end of data, the summary and the footer, in one write; the
        final metadata.yaml. Pending messages are left out."""
        information = self._information()
        record = encode([Metadata('rosbag2', {'serialized_metadata': information})])
        where = MetadataIndex(offset=self.end, length=len(record), name='rosbag2')
        data_end = encode([DataEnd(data_section_crc=0)])
        summary_start = self.end + len(record) + len(data_end)
        self._put(record + data_end + self._summary(summary_start, where) + MAGIC)
        self.close()
        save_metadata(self.path.parent, information)

    def close(self) -> None:
        """Leave no torn bytes behind and let go of the file."""
        if not self._raw.closed:
            try:
                self._raw.truncate(self.end)
            finally:
                self._raw.close()

    def _information(self) -> str:
        return metadata_text(self.path.name, self.channels, self.counts, self.start_ns, self.end_ns)

    def _put(self, data: bytes) -> None:
        self._raw.seek(self.end)
        view = memoryview(data)
        try:
            while view:
                view = view[self._raw.write(view) :]
        except OSError:
            self._raw.truncate(self.end)  # a full disk needs the room for the summary
            raise
        self.end += len(data)

    def _declare(self, channels: Iterable[Channel]) -> list[McapRecord]:
        records: list[McapRecord] = []
        for channel in channels:
            if channel.id in self.channels:
                continue
            schemas = self._schemas()
            self.channels[channel.id] = channel
            self.counts.setdefault(channel.id, 0)
            self._numbered.setdefault(channel.id, 0)
            records += [x for name, x in self._schemas().items() if name not in schemas]
            records.append(self._channel_record(channel))
        return records

    def _schemas(self) -> dict[tuple[str, str, bytes], Schema]:
        schemas: dict[tuple[str, str, bytes], Schema] = {}
        for channel in self.channels.values():
            key = schema_key(channel)
            if channel.msgtype and key not in schemas:
                schemas[key] = Schema(
                    id=len(schemas) + 1, name=key[0], encoding=key[1], data=channel.definition
                )
        return schemas

    def _channel_record(self, channel: Channel) -> ChannelRecord:
        schema = self._schemas().get(schema_key(channel))
        return ChannelRecord(
            id=channel.id,
            topic=channel.topic,
            message_encoding=channel.message_encoding,
            metadata=dict(channel.metadata),
            schema_id=schema.id if schema else 0,
        )

    def _summary(self, summary_start: int, metadata: MetadataIndex) -> bytes:
        """Summary section, summary offsets and footer, with their CRC."""
        groups: list[tuple[Opcode, list[McapRecord]]] = [
            (Opcode.SCHEMA, list(self._schemas().values())),
            (Opcode.CHANNEL, [self._channel_record(x) for x in self.channels.values()]),
            (Opcode.STATISTICS, [self._statistics()]),
            (Opcode.CHUNK_INDEX, list(self._chunks)),
            (Opcode.METADATA_INDEX, [metadata]),
        ]
        summary, offsets = b'', []
        for opcode, records in groups:
            group = encode(records)
            if group:
                offsets.append(SummaryOffset(int(opcode), summary_start + len(summary), len(group)))
            summary += group
        offset_start = summary_start + len(summary)
        summary += encode(offsets)
        footed = summary + struct.pack('<BQQQ', Opcode.FOOTER, 20, summary_start, offset_start)
        return summary + encode([Footer(summary_start, offset_start, zlib.crc32(footed))])

    def _statistics(self) -> Statistics:
        return Statistics(
            attachment_count=0,
            channel_count=len(self.channels),
            channel_message_counts={x: n for x, n in self.counts.items() if n},
            chunk_count=len(self._chunks),
            message_count=self.messages,
            message_end_time=self.end_ns or 0,
            message_start_time=self.start_ns or 0,
            metadata_count=1,
            schema_count=len(self._schemas()),
        )


def schema_key(channel: Channel) -> tuple[str, str, bytes]:
    """What makes two channels share one schema."""
    return channel.msgtype, channel.schema_encoding, channel.definition


def encode(records: Iterable[McapRecord]) -> bytes:
    """The bytes of some records."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]
