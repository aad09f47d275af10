"""What a bag holds, also one that was not closed, and which samples it misses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from qzs_rig.bag.folder import bag_file
from qzs_rig.bag.reader import Source, by_time, is_run_sheet, sheet_in, source_of
from qzs_rig.bag.records import MessageBlock, Stamps
from qzs_rig.bag.scan import Limits
from qzs_rig.errors import BagError

IMU = 'sensor_msgs/msg/Imu'


@dataclass(frozen=True)
class SampleGrid:
    """Samples of a topic against start + k·step: `lost` between the first and the last index that
    any IMU of the bag shows, `off_grid` those whose stamp is on no sample."""

    step_ns: int
    source: str
    received: int
    lost: int
    duplicated: int
    off_grid: int


@dataclass(frozen=True)
class TopicInfo:
    """One topic: first and last log time in ns (None without messages), messages per second."""

    name: str
    msgtype: str
    count: int
    start_ns: int | None
    end_ns: int | None
    rate_hz: float | None
    grid: SampleGrid | None


@dataclass(frozen=True)
class BagInfo:
    """A bag; `damage` says what of it could not be read, `run` is its last run sheet."""

    path: str
    closed: bool
    size_bytes: int
    messages: int
    start_ns: int | None
    end_ns: int | None
    topics: tuple[TopicInfo, ...]
    run: dict[str, Any] | None
    damage: tuple[str, ...]

    @property
    def duration(self) -> float:
        """Seconds from the first to the last message."""
        if self.start_ns is None or self.end_ns is None:
            return 0.0
        return (self.end_ns - self.start_ns) / 1e9

    @property
    def lossless(self) -> bool:
        """Closed, undamaged, and every IMU sample there exactly once."""
        grids = [topic.grid for topic in self.topics if topic.grid]
        return (
            self.closed
            and not self.damage
            and not any(grid.lost or grid.duplicated or grid.off_grid for grid in grids)
        )

    def to_document(self) -> dict[str, Any]:
        """The same for JSON."""
        return {**asdict(self), 'duration_s': self.duration, 'lossless': self.lossless}

    @property
    def text(self) -> str:
        """The same for a terminal."""
        state = 'closed' if self.closed else 'was not closed'
        lines = [
            f'{self.path}: {state}, {self.size_bytes} bytes',
            f'{self.messages} messages over {self.duration:.3f} s from {self.start_ns} ns',
            f'{"topic":24} {"type":36} {"count":>9} {"Hz":>10} {"lost":>6} {"twice":>6} {"off":>6}',
            *map(_line, self.topics),
            *(f'damage: {finding}' for finding in self.damage),
        ]
        return '\n'.join(lines)


def info(path: Path, limits: Limits | None = None) -> BagInfo:
    """Read the whole bag at `path`, checking CRCs; raises BagError only where there is no bag."""
    source = source_of(bag_file(path), limits or Limits(), lenient=True)
    try:
        return _describe(source)
    finally:
        source.close()


def _describe(source: Source) -> BagInfo:
    damage = [] if source.closed or source.damage else ['was not closed']
    stamps, sheets = _read(source, damage)
    types = {channel.topic: channel.msgtype for channel in source.channels.values()}
    grids = _grids({x: stamps[x] for x, msgtype in types.items() if msgtype == IMU}, sheets)
    topics = [_topic(name, types[name], stamps[name], grids.get(name)) for name in sorted(types)]
    filled = [x for x in stamps.values() if len(x)]
    return BagInfo(
        path=str(source.path),
        closed=source.closed,
        size_bytes=source.path.stat().st_size,
        messages=sum(map(len, filled)),
        start_ns=min((int(x.min()) for x in filled), default=None),
        end_ns=max((int(x.max()) for x in filled), default=None),
        topics=tuple(topics),
        run=sheets[-1] if sheets else None,
        damage=tuple(dict.fromkeys([*damage, *source.damage])),
    )


def _read(source: Source, damage: list[str]) -> tuple[dict[str, Stamps], list[dict[str, Any]]]:
    """Log times of each topic in file order, and the run sheets by log time; says in `damage`
    where one is none."""
    parts: dict[int, list[Stamps]] = {}
    sheets: list[MessageBlock] = []
    for block in source.blocks():
        for number in np.unique(block.channels).tolist():
            mine = block.select(block.channels == number)
            parts.setdefault(number, []).append(mine.stamps_ns)
            if is_run_sheet(source.channels[number]):
                sheets.append(mine)
    stamps: dict[str, Stamps] = {x.topic: np.empty(0, np.int64) for x in source.channels.values()}
    for number, found in parts.items():
        topic = source.channels[number].topic
        stamps[topic] = np.concatenate([stamps[topic], *found])
    try:
        return stamps, [sheet_in(source.path, raw) for raw in by_time(sheets).payloads()]
    except BagError as error:
        damage.append(str(error))
        return stamps, []


def _topic(name: str, msgtype: str, stamps_ns: Stamps, grid: SampleGrid | None) -> TopicInfo:
    count = len(stamps_ns)
    start_ns = int(stamps_ns.min()) if count else None
    end_ns = int(stamps_ns.max()) if count else None
    span = 0 if start_ns is None or end_ns is None else end_ns - start_ns
    rate = (count - 1) * 1e9 / span if span else None
    return TopicInfo(name, msgtype, count, start_ns, end_ns, rate, grid)


def _grids(imus: dict[str, Stamps], sheets: Sequence[dict[str, Any]]) -> dict[str, SampleGrid]:
    """By the grid of the run sheet if it gives one, else each by its own median step."""
    imus = {name: stamps for name, stamps in imus.items() if len(stamps)}
    grid = _sheet_grid(sheets)
    if grid is None:
        steps = {name: _median_step(stamps) for name, stamps in imus.items()}
        return {
            name: _count(imus[name], int(imus[name].min()), step, None)
            for name, step in steps.items()
            if step
        }
    start_ns, step_ns = grid
    last = max((int(stamps.max() - start_ns) // step_ns for stamps in imus.values()), default=0)
    return {name: _count(stamps, start_ns, step_ns, last) for name, stamps in imus.items()}


def _count(stamps_ns: Stamps, start_ns: int, step_ns: int, last: int | None) -> SampleGrid:
    """Exact stamps and indices 0 to `last` with a run sheet; without (None), the nearest index."""
    if last is None:
        index = np.rint((stamps_ns - start_ns) / step_ns).astype(np.int64)
        on_grid = np.ones(len(stamps_ns), dtype=bool)
    else:
        index, remainder = np.divmod(stamps_ns - start_ns, step_ns)
        on_grid = (remainder == 0) & (index >= 0)
    seen = np.unique(index[on_grid])
    expected = (int(seen.max(initial=0)) if last is None else last) + 1
    return SampleGrid(
        step_ns=step_ns,
        source='median step' if last is None else 'run sheet',
        received=len(stamps_ns),
        lost=expected - len(seen),
        duplicated=int(on_grid.sum()) - len(seen),
        off_grid=int((~on_grid).sum()),
    )


def _median_step(stamps_ns: Stamps) -> int:
    """The usual step between different stamps (ns); 0 where all are one."""
    steps = np.diff(np.unique(stamps_ns))
    return int(np.median(steps)) if len(steps) else 0


def _sheet_grid(sheets: Sequence[dict[str, Any]]) -> tuple[int, int] | None:
    """start_ns and step_ns of the last sheet that gives both, at its top or one level down."""
    for sheet in reversed(sheets):
        for level in (sheet, *(x for x in sheet.values() if isinstance(x, dict))):
            start_ns, step_ns = level.get('start_ns'), level.get('step_ns')
            if isinstance(start_ns, int) and isinstance(step_ns, int) and step_ns > 0:
                return start_ns, step_ns
    return None


def _line(topic: TopicInfo) -> str:
    rate = '' if topic.rate_hz is None else f'{topic.rate_hz:.3f}'
    grid = topic.grid
    counts = (grid.lost, grid.duplicated, grid.off_grid) if grid else ('', '', '')
    columns = ' '.join(f'{count:>6}' for count in counts)
    return f'{topic.name:24} {topic.msgtype:36} {topic.count:>9} {rate:>10} {columns}'
