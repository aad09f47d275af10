"""Saves every whole message of a bag that was killed, cut or damaged, to a new bag."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

from qzs_rig.bag.folder import bag_file, metadata_text, new_folder, save_metadata
from qzs_rig.bag.limits import DamageError, Limits, expand, expand_torn
from qzs_rig.bag.mcap_file import McapFile
from qzs_rig.bag.mcap_source import NOT_BARE, WINDOW
from qzs_rig.bag.records import CHUNK_HEAD, MAGIC, RECORD_HEAD, Bytes, MessageBlock, parse_records
from qzs_rig.bag.scan import (
    ChunkPlace,
    Declarations,
    Record,
    chunk_place,
    content,
    read_at,
    read_summary,
    walk,
)
from qzs_rig.bag.topics import Channel
from qzs_rig.bag.writer import CHUNK_BYTES
from qzs_rig.errors import BagError

KNOWN = frozenset(Opcode)
PRIVATE = 0x80

SIGNATURES = (b'\x04\x00\x00\x00zstd', b'\x03\x00\x00\x00lz4')
SIGNATURE = re.compile(b'|'.join(SIGNATURES))
"""Name of the compression, which stands at a fixed place in the head of a chunk."""


@dataclass(frozen=True)
class RecoverReport:
    """What was saved from `source` to `out`, and what was not."""

    source: Path
    out: Path
    was_closed: bool
    messages: dict[str, int]
    start_ns: int | None
    end_ns: int | None
    bytes_total: int
    bytes_dropped: int
    findings: tuple[str, ...]

    def to_document(self) -> dict[str, Any]:
        """The report for JSON."""
        return {
            **vars(self),
            'source': str(self.source),
            'out': str(self.out),
            'findings': list(self.findings),
        }

    @property
    def text(self) -> str:
        """The report for a terminal."""
        seconds = (self.end_ns - self.start_ns) / 1e9 if self.end_ns and self.start_ns else 0.0
        lines = [f'{sum(self.messages.values())} messages over {seconds:.3f} s saved to {self.out}']
        lines += [f'  {topic}: {count}' for topic, count in self.messages.items()]
        lines += [f'  {self.bytes_dropped} of {self.bytes_total} bytes dropped', *self.findings]
        return '\n'.join(lines)


def recover(path: Path, out: Path, limits: Limits | None = None) -> RecoverReport:
    """Write what is whole in the bag at `path` to the new folder `out`; the original stays.

    Raises BagError where nothing of an MCAP file is there, or `out` is not new.
    """
    limits = limits or Limits()
    source = bag_file(path)
    if source.suffix != '.mcap':
        raise BagError(f'{source} is not MCAP; only .mcap files can be recovered')
    size = source.stat().st_size
    with source.open('rb') as file:
        if read_at(file, 0, len(MAGIC)) != MAGIC:
            raise BagError(f'{source} does not begin like an MCAP file ({size} bytes); it was lost')
        salvage = Salvage(file, size, limits)
        written = _write(salvage, new_folder(out))
    counts = {written.channels[x].topic: 0 for x in written.channels}
    for channel, count in written.counts.items():
        counts[written.channels[channel].topic] += count
    return RecoverReport(
        source=source,
        out=Path(out),
        was_closed=salvage.was_closed,
        messages=dict(sorted(counts.items())),
        start_ns=written.start_ns,
        end_ns=written.end_ns,
        bytes_total=size,
        bytes_dropped=salvage.dropped,
        findings=tuple(salvage.findings),
    )


class Salvage:
    """A walk through a file that may lie: steps over what is damaged, and notes it."""

    def __init__(self, file: BinaryIO, size: int, limits: Limits) -> None:
        self.was_closed = False
        self.dropped = 0
        self.findings: list[str] = []
        self._file = file
        self._size = size
        self._limits = limits
        self._expanded = 0
        self._declarations = Declarations(limits)
        self._repeated: dict[int, Channel] = {}
        self._read_end()
        self._chunked = self._next_chunk(len(MAGIC)) < size

    @property
    def channels(self) -> dict[int, Channel]:
        """Those repeated at the end of a closed file, which have a CRC, else those met so far."""
        return self._repeated or self._declarations.channels

    def blocks(self) -> Iterator[MessageBlock]:
        """Every whole message of a known channel."""
        at = len(MAGIC)
        while at < self._size:
            record = next(walk(self._file, at, self._size))
            if record.opcode == Opcode.DATA_END and record.fits and record.length == 4:
                return
            try:
                block, at = self._take(record)
            except DamageError as error:
                after = self._next_chunk(at + 1)
                self._drop(at, after, str(error))
                at = after
                continue
            if block is not None and len(block := self._known(block)):
                yield block.repacked()

    def _read_end(self) -> None:
        try:
            summary = read_summary(self._file, self._size, self._limits)
        except DamageError as error:
            self.findings.append(str(error))
            return
        self.was_closed = summary is not None
        self._repeated = summary.channels if summary else {}

    def _take(self, record: Record) -> tuple[MessageBlock | None, int]:
        """Messages of a record, if it holds any, and where to go on."""
        if record.opcode == Opcode.CHUNK:
            place = chunk_place(self._file, record)
            if record.fits:
                return self._whole(place), record.end
            if self.was_closed:
                raise DamageError('the length of a chunk is garbled')
            return self._torn(place), self._size
        if not record.fits:
            raise DamageError('the file ends within a record')
        if record.opcode == Opcode.MESSAGE and self._chunked:
            # some other record with a flipped opcode: no CRC vouches for it
            self._drop(record.at, record.end, 'a message outside of the chunks, skipped')
        elif record.opcode == Opcode.MESSAGE:
            return self._bare(record)
        elif record.opcode in {Opcode.SCHEMA, Opcode.CHANNEL}:
            self._declarations.add(record.opcode, content(self._file, record, self._limits))
        elif record.opcode == Opcode.MESSAGE_INDEX:
            self._check_index(record)
        elif record.opcode not in KNOWN and record.opcode < PRIVATE:
            raise DamageError(f'no record begins with {record.opcode:#04x}')
        return None, record.end

    def _whole(self, place: ChunkPlace) -> MessageBlock | None:
        end = place.data_start + place.data_size
        try:
            self._refuse_bomb(place)
            data = read_at(self._file, place.data_start, place.data_size)
            records = expand(place.compression, data, place.size, place.crc, self._limits)
        except DamageError as error:
            self._drop(place.at, end, f'chunk skipped: {error}')
            return None
        self._expanded += place.size
        block = self._parsed(np.frombuffer(records, dtype=np.uint8), place.at)
        if place.crc:
            return block
        return block.select(self._within(block, place))

    def _torn(self, place: ChunkPlace) -> MessageBlock:
        """The messages that the beginning of the last chunk still yields; no CRC covers them."""
        data = read_at(self._file, place.data_start, self._size - place.data_start)
        records = expand_torn(place.compression, data, place.size, self._limits)
        parsed = parse_records(np.frombuffer(records, dtype=np.uint8))
        block = parsed.messages.select(self._within(parsed.messages, place))
        self._drop(place.at, self._size, f'last chunk is torn, {len(block)} messages of it saved')
        return block

    def _within(self, block: MessageBlock, place: ChunkPlace) -> NDArray[np.bool_]:
        """Without a CRC, a message counts only inside the time span its chunk declares."""
        stamps = block.stamps_ns.astype(np.uint64)
        return (stamps >= place.start_ns) & (stamps <= place.end_ns)

    def _bare(self, record: Record) -> tuple[MessageBlock, int]:
        """Messages that lie outside of chunks, as many as a window takes."""
        if record.length > self._limits.chunk_bytes:
            raise DamageError(f'a message of {record.length} bytes, above the limit')
        size = max(WINDOW, record.end - record.at)
        window = np.frombuffer(read_at(self._file, record.at, size), dtype=np.uint8)
        parsed = parse_records(window, stop=NOT_BARE)
        if not len(parsed.messages):
            raise DamageError('a message record is garbled')
        return parsed.messages, record.at + parsed.end

    def _parsed(self, records: Bytes, at: int) -> MessageBlock:
        parsed = parse_records(records)
        for opcode, start, end in parsed.others:
            self._declarations.add(opcode, records[start:end].tobytes())
        if parsed.end < len(records):
            self.findings.append(f'chunk at byte {at}: a record in it is garbled, the rest dropped')
        return parsed.messages

    def _known(self, block: MessageBlock) -> MessageBlock:
        known = np.isin(block.channels, list(self.channels))
        if known.all():
            return block
        lost = int((~known).sum())
        self.findings.append(f'{lost} messages belong to channels nobody declares; dropped')
        return block.select(known)

    def _refuse_bomb(self, place: ChunkPlace) -> None:
        allowed = self._limits.expanded(self._size)
        if self._expanded + place.size > allowed:
            raise DamageError(f'the file would expand to more than {allowed} bytes')

    def _check_index(self, record: Record) -> None:
        """A garbled length here would jump over whole chunks."""
        head = read_at(self._file, record.start, 6)
        if len(head) < 6 or int.from_bytes(head[2:], 'little') != record.length - 6:
            raise DamageError('a message index is garbled')

    def _next_chunk(self, at: int) -> int:
        """First byte from `at` on where a chunk may begin, or the end of the file."""
        name_at = RECORD_HEAD.size + CHUNK_HEAD.size
        overlap = max(map(len, SIGNATURES)) - 1
        while at < self._size:
            window = read_at(self._file, at, WINDOW)
            found = [match.start() for match in SIGNATURE.finditer(window)]
            for position in found:
                start = at + position - name_at
                if start >= at and self._is_chunk(start):
                    return start
            if len(window) < WINDOW:
                break
            at += WINDOW - overlap - name_at
        return self._size

    def _is_chunk(self, at: int) -> bool:
        record = next(walk(self._file, at, self._size))
        if record.opcode != Opcode.CHUNK:
            return False
        try:
            return chunk_place(self._file, record).crc != 0
        except DamageError:
            return False

    def _drop(self, start: int, end: int, reason: str) -> None:
        self.dropped += end - start
        self.findings.append(f'bytes {start} to {end}: {reason}')


def _write(salvage: Salvage, folder: Path) -> McapFile:
    path = folder / f'{folder.resolve().name}_0.mcap'
    try:
        file = McapFile(path, level=1, chunk_bytes=CHUNK_BYTES)
        try:
            file.begin(())
            for block in salvage.blocks():
                file.add_channels(salvage.channels.values())
                file.append_block(block)
            file.add_channels(salvage.channels.values())
            information = metadata_text(
                path.name, file.channels, file.counts, file.start_ns, file.end_ns
            )
            file.finish(information)
        finally:
            file.close()
        save_metadata(folder, information)
    except OSError as error:
        raise BagError(f'{folder}: {error.strerror}; recover to another disk') from error
    return file
