"""The records of an MCAP file in the order they lie, without trusting what they say."""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel as ChannelRecord
from mcap.records import Schema

from qzs_rig.bag.folder import Channel
from qzs_rig.bag.records import CHUNK_HEAD, MAGIC, RECORD_HEAD

MIB = 1 << 20


class DamageError(Exception):
    """A piece of a bag cannot be used; the caller knows the file and makes it a BagError."""


@dataclass(frozen=True)
class Limits:
    """Refused beyond: bytes of one expanded chunk, of one message definition, channels, and
    expanded bytes of the whole file per byte on disk (small files may reach `expanded_bytes`)."""

    chunk_bytes: int = 64 * MIB
    record_bytes: int = 4 * MIB
    channels: int = 4096
    expansion: int = 1000
    expanded_bytes: int = 256 * MIB

    def expanded(self, file_bytes: int) -> int:
        """Bytes all chunks of a file of `file_bytes` may hold together."""
        return max(self.expanded_bytes, self.expansion * file_bytes)


def expand(compression: str, data: bytes, size: int, crc: int, limits: Limits) -> bytes:
    """The records of a chunk that claims `size` bytes and `crc` (0: none); raises DamageError."""
    if size > limits.chunk_bytes:
        raise DamageError(f'claims {size} bytes, above the limit of {limits.chunk_bytes}')
    try:
        records = EXPANDERS[compression](data, size)
    except KeyError:
        known = ', '.join(filter(None, EXPANDERS))
        raise DamageError(f'compression {compression!r} is unknown, known are {known}') from None
    if len(records) != size:
        raise DamageError(f'claims {size} bytes and holds {len(records)}')
    if crc and zlib.crc32(records) != crc:
        raise DamageError(f'CRC {zlib.crc32(records):08x} is not the {crc:08x} it was written with')
    return records


def expand_torn(compression: str, data: bytes, size: int, limits: Limits) -> bytes:
    """As many bytes as the beginning of a chunk yields; never more than it claims."""
    if size > limits.chunk_bytes:
        return b''
    if compression == 'zstd':
        return _torn_zstd(data, size)
    return data[:size] if compression == '' else b''


def _plain(data: bytes, size: int) -> bytes:
    return data


def _zstd(data: bytes, size: int) -> bytes:
    """The content size in the frame decides what the library allocates: check it first."""
    import zstandard

    try:
        claimed = zstandard.frame_content_size(data)
        if claimed > size:
            raise DamageError(f'expands to {claimed} bytes, not to the {size} it claims')
        decompressor = zstandard.ZstdDecompressor(max_window_size=128 * MIB)
        return decompressor.decompress(data, max_output_size=size) if size else b''
    except zstandard.ZstdError as error:
        raise DamageError(f'zstd: {error}') from None


def _torn_zstd(data: bytes, size: int) -> bytes:
    import zstandard

    parts: list[bytes] = []
    produced = 0
    reader = zstandard.ZstdDecompressor(max_window_size=128 * MIB).stream_reader(data)
    try:
        while produced < size and (part := reader.read(min(MIB, size - produced))):
            parts.append(part)
            produced += len(part)
    except zstandard.ZstdError:
        pass  # the frame ends here: what came out before is whole
    return b''.join(parts)


def _lz4(data: bytes, size: int) -> bytes:
    import lz4.frame  # type: ignore[import-untyped]

    try:
        return bytes(lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1))
    except RuntimeError as error:
        raise DamageError(f'lz4: {error}') from None


EXPANDERS = {'': _plain, 'zstd': _zstd, 'lz4': _lz4}


FOOTER_BYTES = RECORD_HEAD.size + 20 + len(MAGIC)


@dataclass(frozen=True)
class Record:
    """Content of `length` bytes from byte `start` on; `fits` unless the file ends before."""

    opcode: int
    start: int
    length: int
    fits: bool

    @property
    def at(self) -> int:
        """First byte of the record."""
        return self.start - RECORD_HEAD.size

    @property
    def end(self) -> int:
        """First byte after the record."""
        return self.start + self.length


@dataclass(frozen=True)
class ChunkPlace:
    """A chunk in the file; `data_start` and `data_size` locate its compressed records."""

    at: int
    start_ns: int
    end_ns: int
    size: int
    crc: int
    compression: str
    data_start: int
    data_size: int


def read_at(file: BinaryIO, start: int, size: int) -> bytes:
    """Up to `size` bytes from `start` on."""
    file.seek(start)
    return file.read(size)


def walk(file: BinaryIO, start: int, end: int) -> Iterator[Record]:
    """Records from `start` on; the last one may not fit before `end`."""
    at = start
    while at < end:
        head = read_at(file, at, min(RECORD_HEAD.size, end - at))
        if len(head) < RECORD_HEAD.size:
            yield Record(0, at + RECORD_HEAD.size, 0, fits=False)
            return
        opcode, length = RECORD_HEAD.unpack(head)
        record = Record(opcode, at + RECORD_HEAD.size, length, at + len(head) + length <= end)
        yield record
        if not record.fits:
            return
        at = record.end


def chunk_place(file: BinaryIO, record: Record) -> ChunkPlace:
    """The chunk of a record, torn or whole; raises DamageError if it contradicts itself."""
    head = read_at(file, record.start, CHUNK_HEAD.size + 4 + 16 + 8)
    try:
        start_ns, end_ns, size, crc = CHUNK_HEAD.unpack_from(head)
        (name,) = struct.unpack_from('<I', head, CHUNK_HEAD.size)
        (data_size,) = struct.unpack_from('<Q', head, CHUNK_HEAD.size + 4 + name)
        compression = head[CHUNK_HEAD.size + 4 : CHUNK_HEAD.size + 4 + name].decode()
    except (struct.error, UnicodeDecodeError):
        raise DamageError('the head of the chunk is incomplete or garbled') from None
    data_start = record.start + CHUNK_HEAD.size + 4 + name + 8
    if data_start + data_size != record.end:
        raise DamageError('the lengths in the head of the chunk contradict each other')
    return ChunkPlace(record.at, start_ns, end_ns, size, crc, compression, data_start, data_size)


class Declarations:
    """Schemas and channels met so far; the first declaration of an id stands."""

    def __init__(self, limits: Limits) -> None:
        self.channels: dict[int, Channel] = {}
        self._schemas: dict[int, Schema] = {}
        self._limits = limits

    def add(self, opcode: int, content: bytes) -> None:
        """Take in one schema or channel record; raises DamageError where it is garbled."""
        stream = ReadDataStream(io.BytesIO(content))
        try:
            if opcode == Opcode.SCHEMA:
                schema = Schema.read(stream)
                self._schemas.setdefault(schema.id, schema)
            elif opcode == Opcode.CHANNEL:
                self._add_channel(ChannelRecord.read(stream))
        except (McapError, struct.error, UnicodeDecodeError) as error:
            raise DamageError(f'a schema or channel record is garbled ({error})') from None

    def _add_channel(self, record: ChannelRecord) -> None:
        schema = self._schemas.get(record.schema_id)
        if len(self.channels) >= self._limits.channels:
            raise DamageError(f'more than {self._limits.channels} channels')
        self.channels.setdefault(
            record.id,
            Channel(
                id=record.id,
                topic=record.topic,
                msgtype=schema.name if schema else '',
                definition=schema.data if schema else b'',
                schema_encoding=schema.encoding if schema else '',
                message_encoding=record.message_encoding,
                metadata=record.metadata,
            ),
        )


def read_summary(file: BinaryIO, size: int, limits: Limits) -> dict[int, Channel] | None:
    """The channels that a closed file repeats at its end; None for one that was not closed.

    Raises DamageError for a damaged end.
    """
    tail = read_at(file, max(size - FOOTER_BYTES, 0), FOOTER_BYTES)
    if len(tail) < FOOTER_BYTES or not tail.endswith(MAGIC):
        return None
    opcode, length, summary_start, _, crc = struct.unpack('<BQQQI', tail[: -len(MAGIC)])
    if opcode != Opcode.FOOTER or length != 20:
        return None
    footer = size - FOOTER_BYTES
    if not summary_start:
        return {}
    if not len(MAGIC) < summary_start <= footer:
        raise DamageError(f'the footer points to byte {summary_start} for its summary')
    if crc and _summary_crc(file, summary_start, size) != crc:
        raise DamageError('the CRC of the summary does not match')
    declarations = Declarations(limits)
    for record in walk(file, summary_start, footer):
        if not record.fits:
            raise DamageError('the summary is garbled')
        if record.opcode in {Opcode.SCHEMA, Opcode.CHANNEL}:
            declarations.add(record.opcode, content(file, record, limits))
    return declarations.channels


def content(file: BinaryIO, record: Record, limits: Limits) -> bytes:
    """The content of a small record; raises DamageError for one that should be small and is not."""
    if record.length > limits.record_bytes:
        raise DamageError(f'a record of {record.length} bytes, above {limits.record_bytes}')
    return read_at(file, record.start, record.length)


def _summary_crc(file: BinaryIO, start: int, size: int) -> int:
    """CRC of the summary and of the footer up to its CRC field."""
    crc, at, end = 0, start, size - len(MAGIC) - 4
    while at < end:
        part = read_at(file, at, min(1 << 20, end - at))
        if not part:
            break
        crc, at = zlib.crc32(part, crc), at + len(part)
    return crc
