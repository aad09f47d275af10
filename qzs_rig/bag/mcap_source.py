"""Messages of an MCAP file, chunk by chunk, also of files that other recorders wrote."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from mcap.opcode import Opcode

from qzs_rig.bag.limits import DamageError, Limits, expand
from qzs_rig.bag.records import MAGIC, MessageBlock, parse_records
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
from qzs_rig.errors import BagError

WINDOW = 1 << 20
"""Bytes read at once of messages that lie outside of chunks."""

NOT_BARE = frozenset(Opcode) - {Opcode.MESSAGE}


@dataclass(frozen=True)
class Piece:
    """Some messages of the file, none before `start_ns`, on `channels` as far as an index says."""

    at: int
    start_ns: int
    channels: frozenset[int]
    chunk: ChunkPlace | None = None
    size: int = 0


class McapSource:
    """Opened strictly: any damage raises BagError. `lenient` takes an unfinished file as far as it
    goes and lists what is wrong in `damage`."""

    def __init__(self, path: Path, limits: Limits, *, lenient: bool = False) -> None:
        self.path = path
        self.closed = False
        self.damage: list[str] = []
        self._limits = limits
        self._lenient = lenient
        self._pieces: list[Piece] = []
        self._declarations = Declarations(limits)
        with ExitStack() as on_failure:
            self._file = on_failure.enter_context(path.open('rb'))
            self._open()
            on_failure.pop_all()  # it stays open until `close`

    @property
    def channels(self) -> dict[int, Channel]:
        """Channels of the file by id."""
        return self._declarations.channels

    def close(self) -> None:
        """Let go of the file."""
        self._file.close()

    def blocks(self, channels: frozenset[int]) -> Iterator[tuple[int, int, MessageBlock]]:
        """(stamp that neither this nor a later block undercuts, place in the file, messages)."""
        wanted = np.zeros(1 << 16, dtype=bool)
        wanted[list(channels)] = True
        for piece in self._pieces:
            if not piece.channels & channels:
                continue
            try:
                block = self._load(piece)
            except DamageError as error:
                self._report(f'chunk at byte {piece.at}: {error}')
                continue
            mine = wanted[block.channels]
            yield piece.start_ns, piece.at, block if mine.all() else block.select(mine)

    def _open(self) -> None:
        size = self.path.stat().st_size
        if not size:
            raise BagError(f'{self.path} is empty; nothing was recorded')
        if read_at(self._file, 0, len(MAGIC)) != MAGIC:
            raise BagError(f'{self.path} is not an MCAP file; give a bag folder or its .mcap file')
        try:
            summary = read_summary(self._file, size, self._limits)
        except DamageError as error:
            self._report(str(error))
            summary = None
        else:
            self.closed = summary is not None
            if not self.closed:
                self._report_unfinished()
        try:
            self._scan(summary.data_end if summary else size)
            if summary:
                self._declarations.channels = {**self.channels, **summary.channels}
            self._refuse_strays()
            if not self._knows_all_channels():
                self._declare_from_chunks()
        except DamageError as error:
            self._report(str(error))
        self._pieces.sort(key=lambda piece: (piece.start_ns, piece.at))

    def _scan(self, end: int) -> None:
        """Find the pieces and the declarations that lie outside of chunks."""
        bare_until, expanded = 0, 0
        for record in walk(self._file, len(MAGIC), end):
            if record.opcode == Opcode.DATA_END:
                return
            if record.at < bare_until:
                continue
            if not record.fits or not record.opcode:
                if self.closed:
                    self._report(f'the record at byte {record.at} is garbled')
                return
            if record.opcode == Opcode.CHUNK:
                place = chunk_place(self._file, record)
                if place.size <= self._limits.chunk_bytes:  # beyond, it is refused when loaded
                    expanded += place.size
                self._refuse_bomb(expanded, end)
                self._pieces.append(Piece(place.at, place.start_ns, frozenset(), place))
            elif record.opcode == Opcode.MESSAGE_INDEX:
                self._note_index(record)
            elif record.opcode in {Opcode.SCHEMA, Opcode.CHANNEL}:
                self._declarations.add(record.opcode, content(self._file, record, self._limits))
            elif record.opcode == Opcode.MESSAGE:
                bare_until = self._note_bare(record, end)

    def _refuse_strays(self) -> None:
        """Messages lie in chunks, which have CRCs, or all of them outside, never both."""
        chunks = [piece for piece in self._pieces if piece.chunk]
        strays = [piece for piece in self._pieces if not piece.chunk]
        if chunks and strays:
            self._pieces = chunks
            self._report(f'the message at byte {strays[0].at} lies outside of the chunks')

    def _refuse_bomb(self, expanded: int, size: int) -> None:
        allowed = self._limits.expanded(size)
        if expanded > allowed:
            raise BagError(
                f'{self.path} would expand from {size} to more than {allowed} bytes; '
                'raise Limits.expansion if you trust it'
            )

    def _note_index(self, record: Record) -> None:
        """The channels of a chunk are those that have an index after it."""
        if self._pieces and (last := self._pieces[-1]).chunk:
            (channel,) = struct.unpack('<H', read_at(self._file, record.start, 2))
            self._pieces[-1] = replace(last, channels=last.channels | {channel})

    def _note_bare(self, record: Record, end: int) -> int:
        """Messages outside of chunks: as many whole records as a window takes."""
        size = min(max(WINDOW, record.end - record.at), end - record.at)
        if record.length > self._limits.chunk_bytes:
            raise DamageError(f'a message of {record.length} bytes, above the limit')
        parsed = parse_records(self._bytes(record.at, size), stop=NOT_BARE)
        block = parsed.messages
        if not len(block):
            raise DamageError(f'the message at byte {record.at} is garbled')
        channels = frozenset(np.unique(block.channels).tolist())
        start_ns = int(block.stamps_ns.min())
        self._pieces.append(Piece(record.at, start_ns, channels, size=parsed.end))
        return record.at + parsed.end

    def _knows_all_channels(self) -> bool:
        """Chunks without an index, or with channels nobody declared, have to be opened to know."""
        known = self.channels.keys()
        return all(piece.channels and piece.channels <= known for piece in self._pieces)

    def _declare_from_chunks(self) -> None:
        for number, piece in enumerate(self._pieces):
            try:
                block = self._load(piece, declare=True)
            except DamageError as error:
                self._report(f'chunk at byte {piece.at}: {error}')
                continue
            met = frozenset(np.unique(block.channels).tolist())
            self._pieces[number] = replace(piece, channels=met)

    def _load(self, piece: Piece, *, declare: bool = False) -> MessageBlock:
        if piece.chunk is None:
            data = self._bytes(piece.at, piece.size)
        else:
            data = np.frombuffer(self._expanded(piece.chunk), dtype=np.uint8)
        parsed = parse_records(data)
        if parsed.end != len(data):
            raise DamageError(f'the record at its byte {parsed.end} is garbled')
        if declare:
            others = ((op, data[start:end].tobytes()) for op, start, end in parsed.others)
            self._declarations.add_all(others)
        return parsed.messages

    def _expanded(self, place: ChunkPlace) -> bytes:
        data = read_at(self._file, place.data_start, place.data_size)
        return expand(place.compression, data, place.size, place.crc, self._limits)

    def _bytes(self, start: int, size: int) -> np.ndarray[tuple[int], np.dtype[np.uint8]]:
        return np.frombuffer(read_at(self._file, start, size), dtype=np.uint8)

    def _report(self, finding: str) -> None:
        if self._lenient:
            self.damage.append(finding)
            return
        raise BagError(f'{self.path}: {finding}; `qzs-rig bag recover {self.path}` keeps the rest')

    def _report_unfinished(self) -> None:
        if self._lenient:
            self.damage.append('was not closed')
            return
        raise BagError(
            f'{self.path} was not closed (killed or still recording); '
            f'take what is in it with `qzs-rig bag recover {self.path}`'
        )
