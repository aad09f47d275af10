"""New bags: of a run as it goes, at the rate of the rig, or of what is whole in a damaged one."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from qzs_rig.bag.folder import Channel, TopicSpec, absolute, bag_file, declare, new_folder
from qzs_rig.bag.mcap_file import McapFile
from qzs_rig.bag.mcap_source import McapSource
from qzs_rig.bag.records import MAGIC, Bytes, Stamps
from qzs_rig.bag.scan import Limits, read_at
from qzs_rig.errors import BagError, InputError

STAMP_PERIOD_NS = 200_000_000
"""Chunks close on this grid of stamp time: shorter than the wall period, so that a run in real
time is cut by its stamps and the same run gives the same bytes."""

WALL_PERIOD = 0.25
"""Seconds a message may wait in memory when stamps stand still or run slowly."""

CHUNK_BYTES = 1 << 20
LARGEST_MESSAGE = 32 << 20
"""Above, the chunk would be refused by the reader's limits."""


class BagWriter:
    """Writes `<folder>/<folder name>_0.mcap` and metadata.yaml; log time = publish time = stamp.

    A chunk is handed to the system every 0.2 s of stamp time and every 0.25 s of wall time, the
    latter only while `write` or `tick` are called: own a timer that calls `tick`. Not for use
    from several threads at once. The same calls give the same bytes unless the wall clock cut a
    chunk (`wall_cuts`); the messages and their order are the same in any case.
    """

    def __init__(
        self,
        folder: Path,
        topics: Sequence[TopicSpec],
        *,
        level: int | None = 1,
        chunk_bytes: int = CHUNK_BYTES,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """`level` of zstd, None for none; `clock` in seconds, steady. Raises BagError."""
        channels = _channels(topics)
        self.folder = new_folder(folder)
        self.wall_cuts = 0
        self._channels = {channel.topic: channel for channel in channels}
        self._clock = clock
        self._next_cut_ns: int | None = None
        self._wall_limit = math.inf
        self._closed = False
        with self._reporting_disk():
            self._file = McapFile(self.folder, level=level, chunk_bytes=chunk_bytes)
            self._file.begin(channels)

    @property
    def path(self) -> Path:
        """The storage file."""
        return self._file.path

    def write(self, topic: str, stamps_ns: ArrayLike, messages: Sequence[bytes] | Bytes) -> None:
        """n messages at `stamps_ns` (n,): of any length, or rows (n, length) uint8."""
        channel = self._open_channel(topic)
        stamps = _checked_stamps(stamps_ns, len(messages))
        parts = _equal_rows(channel.topic, messages)
        if not parts:
            return
        latest_ns = int(stamps.max())
        with self._reporting_disk():
            for rows in parts:
                self._file.append_rows(channel.id, stamps[: len(rows)], rows)
                stamps = stamps[len(rows) :]
            self._cut_if_due(latest_ns)

    def tick(self) -> None:
        """Hand over what has waited for 0.25 s of wall time; for the owner's timer."""
        if self._clock() >= self._wall_limit and not self._closed:
            self.wall_cuts += 1
            self.flush()

    def flush(self) -> None:
        """Hand everything written so far to the system."""
        if not self._closed:
            with self._reporting_disk():
                self._file.flush()
                self._wall_limit = math.inf

    def close(self) -> None:
        """Write the summary and the final metadata.yaml; a second call does nothing."""
        if self._closed:
            return
        with self._reporting_disk():
            self._file.flush()
            self._file.finish()
            self._closed = True

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def _open_channel(self, topic: str) -> Channel:
        if self._closed:
            raise BagError(f'bag {self.folder} is closed; record to a new folder')
        try:
            return self._channels[absolute(topic)]
        except KeyError:
            known = ', '.join(self._channels)
            raise BagError(f'topic {topic!r} is not recorded here; take one of {known}') from None

    def _cut_if_due(self, stamp_ns: int) -> None:
        """Close the chunk when a stamp passes the grid, else see that the wall clock will."""
        after = (stamp_ns // STAMP_PERIOD_NS + 1) * STAMP_PERIOD_NS
        if self._next_cut_ns is None:
            self._next_cut_ns = after
        if stamp_ns >= self._next_cut_ns:
            self._next_cut_ns = after
            self.flush()
        elif self._wall_limit == math.inf:
            self._wall_limit = self._clock() + WALL_PERIOD
        else:
            self.tick()

    @contextmanager
    def _reporting_disk(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise BagError(self._give_up(error.strerror or str(error))) from error

    def _give_up(self, reason: str) -> str:
        """Close the bag with what reached the disk; say whether it worked."""
        if not hasattr(self, '_file'):
            return f'bag {self.folder} cannot be written ({reason}); choose another folder'
        kept = f'{self.folder}: {reason} after {self._file.messages} messages'
        if not self._closed:
            self._closed = True
            try:
                self._file.finish()
            except (OSError, InputError):
                with suppress(OSError):
                    self._file.close()
                return f'{kept}; free space, then `qzs-rig bag recover {self.folder}`'
        return f'{kept}; the bag is closed and readable up to there, record the rest elsewhere'


def _channels(topics: Sequence[TopicSpec]) -> list[Channel]:
    names = [absolute(spec.name) for spec in topics]
    for name in names:
        if names.count(name) > 1:
            raise BagError(f'topic {name!r} is listed {names.count(name)} times; list it once')
    return [declare(spec, number) for number, spec in enumerate(topics, start=1)]


def _equal_rows(topic: str, messages: Sequence[bytes] | Bytes) -> list[Bytes]:
    """Messages as rows (m, length): equal neighbours in length go together, so that a topic of one
    size is one block."""
    if not isinstance(messages, np.ndarray):
        for length in set(map(len, messages)):
            _check_length(topic, length)
        groups = [(length, b''.join(equal)) for length, equal in groupby(messages, len)]
        return [np.frombuffer(data, np.uint8).reshape(-1, length) for length, data in groups]
    if messages.ndim != 2 or messages.dtype != np.uint8:
        raise ValueError(f'rows {messages.dtype} {messages.shape} are not (n, length) uint8')
    if not len(messages):
        return []
    _check_length(topic, messages.shape[1])
    return [messages]


def _checked_stamps(stamps_ns: ArrayLike, count: int) -> Stamps:
    stamps: Stamps = np.asarray(stamps_ns, dtype=np.int64)
    if stamps.shape != (count,):
        raise ValueError(f'stamps {stamps.shape} do not fit {count} messages')
    if count and stamps.min() < 0:
        raise BagError(f'stamp {stamps.min()} ns is negative; a bag counts from 1970 onwards')
    return stamps


def _check_length(topic: str, length: int) -> None:
    if not 4 <= length <= LARGEST_MESSAGE:
        raise BagError(
            f'message of {length} bytes on {topic} is not CDR of 4 B to 32 MiB; '
            'hand over the raw bytes of the subscription'
        )


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
    source = bag_file(path)
    if source.suffix != '.mcap':
        raise BagError(f'{source} is not MCAP; only .mcap files can be recovered')
    with source.open('rb') as file:
        if read_at(file, 0, len(MAGIC)) != MAGIC:
            raise BagError(f'{source} does not begin like an MCAP file; it was lost')
    salvage = McapSource(source, limits or Limits(), lenient=True)
    try:
        written = _write(salvage, new_folder(out))
    finally:
        salvage.close()
    counts = {written.channels[x].topic: 0 for x in written.channels}
    for channel, count in written.counts.items():
        counts[written.channels[channel].topic] += count
    return RecoverReport(
        source=source,
        out=Path(out),
        was_closed=salvage.closed,
        messages=dict(sorted(counts.items())),
        start_ns=written.start_ns,
        end_ns=written.end_ns,
        bytes_total=salvage.size,
        bytes_dropped=salvage.dropped,
        findings=tuple(salvage.damage),
    )


def _write(salvage: McapSource, folder: Path) -> McapFile:
    try:
        file = McapFile(folder, level=1, chunk_bytes=CHUNK_BYTES)
        try:
            file.begin(())
            for block in salvage.blocks():
                file.add_channels(salvage.channels.values())
                file.append_block(block.repacked())
            file.add_channels(salvage.channels.values())
            file.finish()
        finally:
            file.close()
    except OSError as error:
        raise BagError(f'{folder}: {error.strerror}; recover to another disk') from error
    return file
