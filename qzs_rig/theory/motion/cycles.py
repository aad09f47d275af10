"""Runs side by side until they repeat themselves, compiled: the bookkeeping of the stroboscope.

`past` (6, BACK, WIDTH) holds the last periods of a block of runs, the newest at `slot`: w, w' and
the sums of kernels.Block.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import typeof, void
from numba.extending import register_jitable
from numpy.typing import NDArray

from qzs_rig.mechanics.compiling import kept
from qzs_rig.samples import Array
from qzs_rig.theory.motion.batch import WIDTH
from qzs_rig.theory.motion.kernels import BLOCK, GRID, PERIOD, SCHEDULE, begin

BACK = 33
"""Periods that are remembered: twice the longest cycle looked for, and one."""

DISTINCT = 100.0
"""Tolerances by which two points of a cycle differ at least."""

ROUNDING = 1e-12
"""A return as close as this is one, however slow the motion settles."""

W, VELOCITY, COS, SIN, LOW, HIGH = range(6)
"""Rows of `past`."""


class Rules(NamedTuple):
    """When a run is done: after `periods`, where |w| reaches `limit`, and with `early` where it
    repeats itself within `tolerance` after `longest` periods or fewer."""

    periods: int
    longest: int
    early: bool
    tolerance: float
    limit: float


class Found(NamedTuple):
    """What n runs did: `points` (n, 2, keep), w and w' after each of the last periods; `cycle`
    (n,), periods of the cycle, 0 without, -1 where the run was lost, and `settled` (n,) when that
    was found; `figures` (n, 6): w, w' at the end, then Block's sums, mean and extremes over the
    cycle or, without one, over the last 32 periods."""

    points: Array
    cycle: NDArray[np.int64]
    settled: NDArray[np.int64]
    figures: Array

    def part(self, which: slice) -> Found:
        """Some of the runs, to be filled in place."""
        points, cycle, settled, figures = self
        return Found(points[which], cycle[which], settled[which], figures[which])


def found(runs: int, periods: int, keep: int) -> Found:
    """Room for what `settle` finds, of runs that have not settled."""
    cycle, settled = np.zeros(runs, dtype=np.int64), np.full(runs, periods, dtype=np.int64)
    return Found(np.empty((runs, 2, keep)), cycle, settled, np.empty((runs, 6)))


RULES, FOUND = typeof(Rules(1, 1, True, 1.0, 1.0)), typeof(found(1, 1, 1))


@register_jitable
def look_back(past: Any, slot: int, longest: int, tolerance: float, found: Any) -> None:
    """`found` (WIDTH,): after how few periods, up to `longest`, each run has come back, or 0."""
    for column in range(WIDTH):
        found[column] = 0.0
    for period in range(1, longest + 1):
        before = (slot - period) % BACK
        for column in range(WIDTH):
            near = abs(past[W, slot, column] - past[W, before, column]) <= tolerance
            near &= abs(past[VELOCITY, slot, column] - past[VELOCITY, before, column]) <= tolerance
            found[column] = period if near and found[column] == 0.0 else found[column]


@register_jitable
def apart(past: Any, column: int, one: int, other: int, scale: float) -> float:
    """Distance of two remembered points; `scale` is what makes w' comparable to w."""
    one, other = one % BACK, other % BACK
    across = abs(past[W, one, column] - past[W, other, column])
    along = scale * abs(past[VELOCITY, one, column] - past[VELOCITY, other, column])
    return float(max(across, along))


@register_jitable
def returned(
    past: Any, slot: int, column: int, period: int, age: int, scale: float, tolerance: float
) -> float:
    """How far a motion that comes back after `period` may still wander: what is left of it.

    Later returns are taken to shrink as the last ones did. Infinite where they do not, and where
    the run nearly comes back after a part of the period: it may do so once its transient is gone.
    """
    lag = period * max(1, 8 // period)
    if age <= lag + period:
        return np.inf
    for part in range(1, period):
        if period % part == 0 and apart(past, column, slot, slot - part, scale) <= (
            DISTINCT * tolerance
        ):
            return np.inf
    near = apart(past, column, slot, slot - period, scale)
    if near <= ROUNDING:
        return 0.0
    far = apart(past, column, slot - lag, slot - lag - period, scale)
    return near * (lag // period) / (1.0 - near / far) if near < far else np.inf


@register_jitable
def finish(
    past: Any, slot: int, column: int, cycle: int, age: int, periods: int, points: Any, figures: Any
) -> None:
    """Fill the `points` (2, keep) that the cycle saved, and the six `figures` of a run."""
    keep = points.shape[1]
    for late in range(age + 1, periods + 1):
        place = late - (periods - keep) - 1
        if place >= 0:
            back = (age - late) % cycle
            points[W, place] = past[W, (slot - back) % BACK, column]
            points[VELOCITY, place] = past[VELOCITY, (slot - back) % BACK, column]
    end = (slot - (age - periods) % cycle) % BACK if cycle else slot
    figures[W], figures[VELOCITY] = past[W, end, column], past[VELOCITY, end, column]
    span = cycle if cycle else min(age, BACK - 1)
    figures[COS] = figures[SIN] = 0.0
    figures[LOW], figures[HIGH] = np.inf, -np.inf
    for back in range(span):
        k = (slot - back) % BACK
        figures[COS] += past[COS, k, column] / span
        figures[SIN] += past[SIN, k, column] / span
        figures[LOW] = min(figures[LOW], past[LOW, k, column])
        figures[HIGH] = max(figures[HIGH], past[HIGH, k, column])


@register_jitable
def remember(past: Any, slot: int, runs: Any) -> None:
    """Put the end of this period and its sums into `past`."""
    for column in range(WIDTH):
        past[W, slot, column] = runs.w[0, column]
        past[VELOCITY, slot, column] = runs.h[column] * runs.y[0, column]
        past[COS, slot, column], past[SIN, slot, column] = runs.cos[column], runs.sin[column]
        past[LOW, slot, column], past[HIGH, slot, column] = runs.low[column], runs.high[column]


@register_jitable
def lose(points: Any, figures: Any, place: int) -> None:
    """NaN for what a run that has left the law would still have given."""
    points[:, max(place, 0) :] = np.nan
    figures[:] = np.nan


@kept(void(PERIOD, BLOCK, GRID, GRID, SCHEDULE, RULES, FOUND), error_model='numpy')
def settle(
    advance: Any, runs: Any, table: Any, numbers: Any, schedule: Any, rules: Any, found: Any
) -> None:
    """Carry the runs of Batch.table and Batch.numbers through their periods, by `rules`.

    A run that is done makes room for the next. What an early exit saves is filled in.
    """
    n, keep, periods = found.points.shape[0], found.points.shape[2], rules.periods
    past, period_of = np.zeros((6, BACK, WIDTH)), np.zeros(WIDTH)
    carried, age = np.full(WIDTH, -1), np.zeros(WIDTH, np.int64)
    following, busy, slot = 0, 0, 0
    while True:
        for column in range(WIDTH):
            if carried[column] < 0 and following < n:
                begin(runs, column, table, numbers, following, schedule)
                carried[column], age[column] = following, 0
                following, busy = following + 1, busy + 1
        if busy == 0:
            return
        advance(runs, schedule)
        slot = (slot + 1) % BACK
        remember(past, slot, runs)
        look_back(past, slot, rules.longest, rules.tolerance, period_of)
        for column in range(WIDTH):
            run = carried[column]
            if run < 0:
                continue
            age[column] += 1
            points, figures = found.points[run], found.figures[run]
            place = age[column] - (periods - keep) - 1
            if place >= 0:
                points[W, place] = past[W, slot, column]
                points[VELOCITY, place] = past[VELOCITY, slot, column]
            if not (runs.high[column] < rules.limit and runs.low[column] > -rules.limit):
                found.cycle[run], found.settled[run] = -1, age[column]
                lose(points, figures, place)
                carried[column], busy = -1, busy - 1
                continue
            left, period = np.inf, int(period_of[column])
            if period > 0:
                scale = max(1.0, runs.h[column] / schedule.step)
                left = returned(past, slot, column, period, age[column], scale, rules.tolerance)
            if found.cycle[run] == 0 and left <= rules.tolerance:
                found.cycle[run], found.settled[run] = period, age[column]
            if age[column] == periods or (rules.early and found.cycle[run] > 0):
                finish(past, slot, column, found.cycle[run], age[column], periods, points, figures)
                carried[column], busy = -1, busy - 1
