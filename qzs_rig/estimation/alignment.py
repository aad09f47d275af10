"""Two irregularly stamped streams brought onto one uniform grid.

Real drivers stamp with their own clock, jitter and rate, and lose messages. The grid starts at a
base sample and steps by the nominal step of the slower stream. A stream is read at a grid time by
the cubic through the four stamps around it; where a stamp *is* the grid time its sample passes
through bit by bit, so that the rig's own streams come out untouched. Stamps are believed: jitter
of a stamp that is not jitter of the sampling turns into noise.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import GapError
from qzs_rig.samples import NS, Array, Stamps

FIRST = 64
"""Samples of each stream from which the nominal step is estimated."""
GAP = 1.5
"""Nominal steps between two stamps from which samples count as lost."""
BRIDGE = 4.0
"""Nominal steps that the cubic still bridges; over a longer gap the grid holds NaN."""
CLOCK_JUMP_NS = 60 * NS
"""A gap that long, forward or back, is a clock that was set, not a loss."""
MEMORY = 16384
"""Samples kept of a stream whose partner does not come; older ones are dropped and counted."""


class StreamCounts(NamedTuple):
    """What became of the samples of one stream: `received` in all; `lost` that never came;
    `duplicated`, `reordered`: dropped, because their stamp had come or had been passed;
    `unmatched`: dropped, because the other stream did not come for too long."""

    received: int = 0
    lost: int = 0
    duplicated: int = 0
    reordered: int = 0
    unmatched: int = 0


class Aligned(NamedTuple):
    """Samples k at start_ns + k step_ns, base (n, c) and top (n, c'). Rows that lie in a gap of a
    stream are NaN there; the next piece follows this one without a break."""

    start_ns: int
    step_ns: int
    base: Array
    top: Array


class Aligner:
    """Push the streams as they come, take what both of them cover."""

    def __init__(self, step_ns: int | None = None, columns: int = 4) -> None:
        """`step_ns` sets the grid's step; None takes the slower stream's nominal step."""
        self._base = _Stream('base', columns)
        self._top = _Stream('top', columns)
        self._step_ns = step_ns
        self._next_ns: int | None = None

    def push_base(self, stamps_ns: Stamps, data: Array) -> None:
        """Take samples `data` (n, columns) of the base at `stamps_ns` (n,) int64; raises GapError
        if its clock jumps by more than CLOCK_JUMP_NS."""
        self._base.push(stamps_ns, data)

    def push_top(self, stamps_ns: Stamps, data: Array) -> None:
        """As push_base, for the top."""
        self._top.push(stamps_ns, data)

    @property
    def counts(self) -> dict[str, StreamCounts]:
        """The counts of 'base' and 'top' so far."""
        return {stream.name: StreamCounts(**stream.counts) for stream in (self._base, self._top)}

    def take(self, final: bool = False) -> Aligned:
        """The grid samples that both streams cover and that were not taken yet, maybe none. A
        sample between stamps waits for three stamps behind it, so that the values do not depend
        on when they are taken; with `final` nothing more will come, and one is enough."""
        if self._next_ns is None and not self._begin(final):
            return Aligned(0, self._step_ns or 0, self._base.none(), self._top.none())
        start, step = self._next_ns or 0, self._step_ns or 1
        last = min(stream.covered(final, start, step) for stream in (self._base, self._top))
        grid = np.arange(start, last + 1, step, dtype=np.int64)
        base, top = self._base.at(grid), self._top.at(grid)
        self._next_ns = start + len(grid) * step
        for stream in (self._base, self._top):
            stream.forget(self._next_ns)
        return Aligned(start, step, base, top)

    def _begin(self, final: bool) -> bool:
        """Choose step and first grid time, once both streams have shown their step."""
        enough = 2 if final else FIRST
        if min(len(self._base.stamps), len(self._top.stamps)) < enough:
            return False
        for stream in (self._base, self._top):
            stream.settle_step()
        if self._step_ns is None:
            self._step_ns = max(round(self._base.step_ns), round(self._top.step_ns))
        later = self._base.stamps[self._base.stamps >= self._top.stamps[0]]
        if not len(later):
            return False
        self._next_ns = int(later[0])
        for stream in (self._base, self._top):
            stream.forget(self._next_ns)
        return True


class _Stream:
    """The recent samples of one stream, in strictly increasing order of stamps."""

    def __init__(self, name: str, columns: int) -> None:
        self.name = name
        self.stamps: Stamps = np.empty(0, dtype=np.int64)
        self.data: Array = np.empty((0, columns))
        self.step_ns = 0.0
        self.counts = StreamCounts()._asdict()

    def none(self) -> Array:
        return np.empty((0, self.data.shape[1]))

    def push(self, stamps: Stamps, data: Array) -> None:
        if data.shape != (len(stamps), self.data.shape[1]):
            raise ValueError(
                f'{self.name}: data {data.shape} does not fit {len(stamps)} stamps and '
                f'{self.data.shape[1]} columns'
            )
        self._check_clock(stamps)
        self.counts['received'] += len(stamps)
        fresh = self._fresh(stamps)
        self._count_lost(stamps[fresh])
        self.stamps = np.concatenate([self.stamps, stamps[fresh]])
        self.data = np.concatenate([self.data, data[fresh]])
        surplus = len(self.stamps) - MEMORY
        if surplus > 0:
            self.counts['unmatched'] += surplus
            self._drop(surplus)

    def settle_step(self) -> None:
        """Estimate the nominal step from the stamps so far, and count what was lost in them."""
        self.step_ns = nominal_step(self.stamps[:FIRST])
        self.counts['lost'] += _lost(np.diff(self.stamps), self.step_ns)

    def covered(self, final: bool, start_ns: int, step_ns: int) -> int:
        """Latest time that can be read for good: three stamps follow it, or only stamps that lie
        on the grid themselves."""
        latest = self.stamps[-3:]
        if final and len(latest):
            return int(latest[-1])
        if len(latest) < 3:
            return start_ns - 1
        on_grid = not ((latest - start_ns) % step_ns).any() and np.diff(latest).max() <= step_ns
        return int(latest[-1] if on_grid else latest[0])

    def at(self, grid: Stamps) -> Array:
        """The stream at the times `grid` (m,), (m, columns); NaN in gaps and before its start."""
        stamps, data = self.stamps, self.data
        if not len(grid) or len(stamps) < 2:
            return np.full((len(grid), data.shape[1]), np.nan)
        place = np.searchsorted(stamps, grid)
        known = np.minimum(place, len(stamps) - 1)
        exact = stamps[known] == grid
        if bool(exact.all()):
            return np.take(data, known, axis=0)
        values = np.full((len(grid), data.shape[1]), np.nan)
        first, bridged = self._nodes(place)
        values[bridged] = _cubic(stamps, data, grid[bridged], first[bridged])
        values[exact] = data[known[exact]]
        return values

    def _nodes(self, place: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
        """First of the four stamps for times before stamp `place`, none of them across a gap, and
        whether there are four."""
        breaks = np.flatnonzero(np.diff(self.stamps) > BRIDGE * self.step_ns) + 1
        starts = np.concatenate([[0], breaks])
        ends = np.concatenate([breaks, [len(self.stamps)]])
        part = np.searchsorted(starts, place, side='right') - 1
        first = np.maximum(starts[part], np.minimum(place - 2, ends[part] - 4))
        inside = (place > starts[part]) & (place < ends[part])
        return first, inside & (first + 4 <= ends[part])

    def forget(self, before_ns: int) -> None:
        """Drop what no later grid time needs: all but four stamps before `before_ns`."""
        self._drop(max(0, int(np.searchsorted(self.stamps, before_ns)) - 4))

    def _drop(self, count: int) -> None:
        self.stamps, self.data = self.stamps[count:], self.data[count:]

    def _fresh(self, stamps: Stamps) -> NDArray[np.bool_]:
        """Which samples come later than all before them; counts the others."""
        before = np.concatenate([self.stamps[-1:], stamps])
        passed = np.maximum.accumulate(before)[: len(before) - 1]
        fresh = np.ones(len(stamps), dtype=bool)
        fresh[len(stamps) - len(passed) :] = stamps[len(stamps) - len(passed) :] > passed
        for stamp, place in zip(stamps[~fresh], np.flatnonzero(~fresh), strict=True):
            seen = stamp in self.stamps or stamp in stamps[:place]
            self.counts['duplicated' if seen else 'reordered'] += 1
        return fresh

    def _check_clock(self, stamps: Stamps) -> None:
        steps = np.diff(np.concatenate([self.stamps[-1:], stamps]))
        jumps = steps[np.abs(steps) > CLOCK_JUMP_NS]
        if len(jumps):
            raise GapError(
                f'clock of {self.name} jumped by {int(jumps[0]) / NS:.3f} s; analyze the parts '
                'before and after one by one'
            )

    def _count_lost(self, fresh: Stamps) -> None:
        if self.step_ns and len(self.stamps):
            steps = np.diff(np.concatenate([self.stamps[-1:], fresh]))
            self.counts['lost'] += _lost(steps, self.step_ns)


def nominal_step(stamps: Stamps) -> float:
    """Step of a stream (ns) from its first stamps (n >= 2): the median of their differences gives
    the sample numbers, missing ones included, and these the mean step. Exact if the stamps lie on
    a grid."""
    steps = np.diff(stamps)
    numbers = np.concatenate([[0], np.cumsum(np.maximum(np.rint(steps / np.median(steps)), 1))])
    offset = numbers - numbers.mean()
    slope = float(offset @ (stamps - stamps[0])) / float(offset @ offset)
    nearest = round(slope)
    on_grid = bool(np.all(stamps - stamps[0] == nearest * numbers.astype(np.int64)))
    return float(nearest) if on_grid else slope


def _lost(steps: Stamps, step_ns: float) -> int:
    wide = steps[steps > GAP * step_ns]
    return int(np.sum(np.rint(wide / step_ns) - 1))


def _cubic(stamps: Stamps, data: Array, grid: Stamps, first: NDArray[np.intp]) -> Array:
    """Lagrange's cubic through the stamps `first` to `first` + 3 at each grid time."""
    nodes = first[:, None] + np.arange(4)
    # Integers are subtracted first: stamps since 1970 have no room for nanoseconds in a float.
    x = (stamps[nodes] - grid[:, None]).astype(np.float64)
    values = np.zeros((len(grid), data.shape[1]))
    for i in range(4):
        weight = np.ones(len(grid))
        for j in range(4):
            if j != i:
                weight *= x[:, j] / (x[:, j] - x[:, i])
        values += weight[:, None] * data[nodes[:, i]]
    return values
