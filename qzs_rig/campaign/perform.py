"""Performing a campaign: what it will take, and from what is kept already to the table."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from qzs_rig.campaign import ledger as ledgers
from qzs_rig.campaign import table_file
from qzs_rig.campaign.finished import Finished
from qzs_rig.campaign.ledger import Ledger
from qzs_rig.campaign.plan import Plan
from qzs_rig.campaign.runners import Runner
from qzs_rig.campaign.sampling import LatinHypercube
from qzs_rig.errors import InputError
from qzs_rig.theory.balance.newton import one_thread

Progress = Callable[[int], None]
ENOUGH = 0.05
"""Seconds of work from which a point's share is known well enough to plan by."""
SPOTS = 8
"""Places in the campaign at which points are timed: those at its start may be slow or quick."""
GROWTH = 8


@dataclass(frozen=True)
class Performed:
    """A finished campaign: `kept` points were there before, `first_s` is when the first new chunk
    was done (None: nothing was left to do), `wall_s` when the table was."""

    table: Finished
    kept: int
    damaged: int
    first_s: float | None
    wall_s: float


@one_thread
def perform(
    plan: Plan, folder: Path, runner: Runner, kind: str | None, progress: Progress
) -> Performed:
    """Compute what `folder` does not hold yet, and write the table there as `kind` (None: as is
    usual).

    `progress(points)` is told the points done so far, first those found. Whatever ends it early,
    KeyboardInterrupt too, the chunks done are kept; the same call goes on from there. BLAS is held
    to one thread all the while: threads that each hold and release it would change its sums.
    """
    usual = table_file.format_of(kind)
    began = time.perf_counter()
    with ledgers.opened(folder, plan) as ledger:
        there = ledger.table
        if there is not None:
            ledger.clear()
            if kind and there.suffix != f'.{kind}':
                raise InputError(
                    f'{there} is complete; nothing is written twice: leave out --format, or give '
                    'another --out'
                )
            return Performed(Finished(there), plan.points, 0, None, 0.0)
        damaged = [number for number in ledger.kept() if not ledger.sound(number)]
        for number in damaged:
            ledger.forget(number)
        found = _points(plan, ledger.kept())
        first = _compute(ledger, runner, found, progress, began)
        finished = table_file.write(ledger, usual)
        ledger.clear()
    return Performed(finished, found, len(damaged), first, time.perf_counter() - began)


def _compute(
    ledger: Ledger, runner: Runner, done: int, progress: Progress, began: float
) -> float | None:
    """Fill the ledger; the seconds to the first chunk, if there was one to do."""
    plan, kept, first = ledger.plan, set(ledger.kept()), None
    progress(done)
    left = [number for number in range(plan.chunks) if number not in kept]
    for number, part in runner.results(plan, left) if left else ():
        ledger.keep(number, part)
        first = first or time.perf_counter() - began
        done += _points(plan, [number])
        progress(done)
    return first


def points_kept(plan: Plan, folder: Path) -> int:
    """Points of `plan` that `folder` holds, whoever computed them and however that ended."""
    ledger = Ledger(folder, plan)
    return plan.points if ledger.table is not None else _points(plan, ledger.kept())


def _points(plan: Plan, numbers: Sequence[int]) -> int:
    return sum(stop - first for first, stop in map(plan.part, numbers))


@dataclass(frozen=True)
class Expected:
    """`point_s` seconds a point on one thread here, timed on `timed` points; bytes of memory for
    the chunks under way, and of the table on the disk."""

    point_s: float
    timed: int
    memory: int
    table: int


def expected(plan: Plan, chunks_under_way: int) -> Expected:
    """Time growing numbers of points, at most one chunk. Compiling is not counted."""
    most = min(plan.chunk, plan.points)
    count = min(plan.task.block, most)
    _timed(plan, count)  # a kernel is compiled, or taken from the disk
    took = _timed(plan, count)
    while took < ENOUGH and count < most:
        count = min(GROWTH * count, most)
        took = _timed(plan, count)
    row = 8 * (len(plan.varied) + len(plan.task.outputs)) + 4
    columns = 1  # one at a time in the summary
    if isinstance(plan.sample, LatinHypercube):
        columns = 3 * len(plan.varied)  # strata, places and samples while it is drawn
    memory = 8 * plan.points * columns + 2 * row * plan.chunk * chunks_under_way
    return Expected(took / count, count, memory, row * plan.points)


def _timed(plan: Plan, count: int) -> float:
    """Seconds for `count` points, in equal parts from all over the campaign."""
    spots = max(1, min(SPOTS, count // plan.task.block))
    each = np.diff(np.linspace(0, count, spots + 1).astype(int)).tolist()
    began = time.perf_counter()
    for spot, size in enumerate(each):
        first = (2 * spot + 1) * (plan.points - size) // (2 * spots)
        plan.task.evaluate(plan.between(first, first + size), plan.options)
    return time.perf_counter() - began
