"""Messages of an MCAP file as they lie in it, of anyone's and of one that may be damaged."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

from qzs_rig.bag.folder import Channel
from qzs_rig.bag.records import CHUNK_HEAD, MAGIC, RECORD_HEAD, Bytes, MessageBlock, parse_records
from qzs_rig.bag.scan import (
    ChunkPlace,
    DamageError,
    Declarations,
    Limits,
    Record,
    chunk_place,
    content,
    expand,
    expand_torn,
    read_at,
    read_summary,
    walk,
)
from qzs_rig.errors import BagError

WINDOW = 1 << 20
"""Bytes read at once of messages that lie outside of chunks."""

NOT_BARE = frozenset(Opcode) - {Opcode.MESSAGE}
KNOWN = frozenset(Opcode)
PRIVATE = 0x80

SIGNATURES = (b'\x04\x00\x00\x00zstd', b'\x03\x00\x00\x00lz4')
SIGNATURE = re.compile(b'|'.join(SIGNATURES))
"""Name of the compression, which stands at a fixed place in the head of a chunk."""


class McapSource:
    """One walk through a file. What is damaged raises BagError; if `lenient`, it is stepped over
    and listed in `damage`, and its size counted in `dropped`."""

    def __init__(self, path: Path, limits: Limits, *, lenient: bool = False) -> None:
        self.path = path
        self.closed = False
        self.damage: list[str] = []
        self.dropped = 0
        self.size = path.stat().st_size
        self._limits = limits
        self._lenient = lenient
        self._expanded = 0
        self._declarations = Declarations(limits)
        self._repeated: dict[int, Channel] = {}
        with ExitStack() as on_failure:
            self._file = on_failure.enter_context(path.open('rb'))
            self._open()
            on_failure.pop_all()  # it stays open until `close`

    @property
    def channels(self) -> dict[int, Channel]:
        """Those repeated at the end of a closed file, which have a CRC, else those met so far."""
        return self._repeated or self._declarations.channels

    def close(self) -> None:
        """Let go of the file."""
        self._file.close()

    def blocks(self, channels: frozenset[int] | None = None) -> Iterator[MessageBlock]:
        """Every whole message, of some channels or of all that are declared, in file order."""
        at, self._expanded = len(MAGIC), 0
        while at < self.size:
            record = next(walk(self._file, at, self.size))
            if record.opcode == Opcode.DATA_END and record.fits and record.length == 4:
                return
            try:
                block, at = self._take(record, channels)
            except DamageError as error:
                after = self._next_chunk(at + 1)
                self._drop(at, after, str(error))
                at = after
                continue
            if block is not None and len(block := self._wanted(block, channels)):
                yield block

    def _open(self) -> None:
        if not self.size:
            raise BagError(f'{self.path} is empty; nothing was recorded')
        if read_at(self._file, 0, len(MAGIC)) != MAGIC:
            raise BagError(f'{self.path} is not an MCAP file; give a bag folder or its .mcap file')
        try:
            summary = read_summary(self._file, self.size, self._limits)
        except DamageError as error:
            self._find(str(error))
        else:
            self.closed = summary is not None
            self._repeated = summary or {}
            if not self.closed and not self._lenient:
                raise BagError(
                    f'{self.path} was not closed (killed or still recording); '
                    f'take what is in it with `qzs-rig bag recover {self.path}`'
                )
        self._chunked = self._next_chunk(len(MAGIC)) < self.size
        if not self._repeated and not self._lenient:
            for _ in self.blocks():  # only a walk tells the channels
                pass

    def _take(
        self, record: Record, channels: frozenset[int] | None
    ) -> tuple[MessageBlock | None, int]:
        """Messages of a record, if it holds any, and where to go on."""
        if record.opcode == Opcode.CHUNK:
            place = chunk_place(self._file, record)
            if record.fits:
                return None if self._unwanted(record, channels) else self._whole(place), record.end
            if self.closed:
                raise DamageError('the length of a chunk is garbled')
            return self._torn(place), self.size
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
            self._indexed(record)
        elif record.opcode not in KNOWN and record.opcode < PRIVATE:
            raise DamageError(f'no record begins with {record.opcode:#04x}')
        return None, record.end

    def _indexed(self, record: Record) -> int:
        """The channel of a message index. A garbled length here would jump over whole chunks."""
        head = read_at(self._file, record.start, 6)
        if len(head) < 6 or int.from_bytes(head[2:], 'little') != record.length - 6:
            raise DamageError('a message index is garbled')
        return int.from_bytes(head[:2], 'little')

    def _unwanted(self, chunk: Record, channels: frozenset[int] | None) -> bool:
        """Whether the indexes after a chunk, if it has any, name none of `channels`."""
        if channels is None:
            return False
        found = set()
        for record in walk(self._file, chunk.end, self.size):
            if record.opcode != Opcode.MESSAGE_INDEX or not record.fits:
                break
            found.add(self._indexed(record))
        return bool(found) and found.isdisjoint(channels)

    def _whole(self, place: ChunkPlace) -> MessageBlock | None:
        end = place.data_start + place.data_size
        try:
            self._refuse_bomb(place)
            data = read_at(self._file, place.data_start, place.data_size)
            records = expand(place.compression, data, place.size, place.crc, self._limits)
        except DamageError as error:
            self._drop(place.at, end, f'chunk at byte {place.at} skipped: {error}')
            return None
        self._expanded += place.size
        block = self._parsed(np.frombuffer(records, dtype=np.uint8), place.at)
        if place.crc:
            return block
        inside = self._within(block, place)
        if not inside.all():
            self._find(f'chunk at byte {place.at}: messages beyond its time span, dropped')
        return block.select(inside)

    def _torn(self, place: ChunkPlace) -> MessageBlock:
        """The messages that the beginning of the last chunk still yields; no CRC covers them."""
        data = read_at(self._file, place.data_start, self.size - place.data_start)
        records = expand_torn(place.compression, data, place.size, self._limits)
        block = parse_records(np.frombuffer(records, dtype=np.uint8)).messages
        block = block.select(self._within(block, place))
        self._drop(place.at, self.size, f'last chunk is torn, {len(block)} messages of it saved')
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
            self._find(
                f'chunk at byte {at}: the record at its byte {parsed.end} is garbled, '
                'the rest dropped'
            )
        return parsed.messages

    def _wanted(self, block: MessageBlock, channels: frozenset[int] | None) -> MessageBlock:
        known = np.isin(block.channels, list(self.channels))
        if not known.all():
            lost = int((~known).sum())
            self._find(f'{lost} messages belong to channels nobody declares; dropped')
        wanted = known if channels is None else np.isin(block.channels, list(channels)) & known
        return block if wanted.all() else block.select(wanted)

    def _refuse_bomb(self, place: ChunkPlace) -> None:
        allowed = self._limits.expanded(self.size)
        if self._expanded + place.size > allowed:
            raise DamageError(
                f'the file would expand to more than {allowed} bytes; '
                'raise Limits.expansion if you trust it'
            )

    def _next_chunk(self, at: int) -> int:
        """First byte from `at` on where a chunk may begin, or the end of the file."""
        name_at = RECORD_HEAD.size + CHUNK_HEAD.size
        overlap = max(map(len, SIGNATURES)) - 1
        while at < self.size:
            window = read_at(self._file, at, WINDOW)
            found = [match.start() for match in SIGNATURE.finditer(window)]
            for position in found:
                start = at + position - name_at
                if start >= at and self._is_chunk(start):
                    return start
            if len(window) < WINDOW:
                break
            at += WINDOW - overlap - name_at
        return self.size

    def _is_chunk(self, at: int) -> bool:
        record = next(walk(self._file, at, self.size))
        if record.opcode != Opcode.CHUNK:
            return False
        try:
            return chunk_place(self._file, record).crc != 0
        except DamageError:
            return False

    def _drop(self, start: int, end: int, reason: str) -> None:
        self.dropped += end - start
        self._find(f'bytes {start} to {end}: {reason}')

    def _find(self, finding: str) -> None:
        """List what is damaged, or raise."""
        if not self._lenient:
            raise BagError(
                f'{self.path}: {finding}; `qzs-rig bag recover {self.path}` keeps the rest'
            )
        self.damage.append(finding)
