"""An MCAP file under way: whole chunks go to the system at once, the summary at the end."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path

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

from qzs_rig.bag.folder import Channel, metadata_text, save_metadata
from qzs_rig.bag.records import MAGIC, Bytes, ChunkBuilder, MessageBlock, Stamps


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
