"""Performing a campaign: from what is kept already to the finished table."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from qzs_rig.campaign import ledger as ledgers
from qzs_rig.campaign import table
from qzs_rig.campaign.ledger import Ledger
from qzs_rig.campaign.part import Part
from qzs_rig.campaign.plan import Plan
from qzs_rig.campaign.table import Finished
from qzs_rig.errors import InputError
from qzs_rig.theory.balance.one_thread import one_thread

Progress = Callable[[int], None]


class Runner(Protocol):
    """Who computes: Threads or Cluster."""

    @property
    def text(self) -> str:
        """In words."""

    def results(self, plan: Plan, numbers: Sequence[int]) -> Iterator[tuple[int, Part]]:
        """(chunk, figures) of each of the chunks `numbers`, in any order."""


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
    table.refuse_missing(kind or '')
    began = time.perf_counter()
    with ledgers.opened(folder, plan) as ledger:
        there = ledger.table
        if there is not None:
            ledger.clear()
            return _there(plan, there, kind)
        damaged = [number for number in ledger.kept() if not ledger.sound(number)]
        for number in damaged:
            ledger.forget(number)
        found = _points(plan, ledger.kept())
        first = _compute(ledger, runner, found, progress, began)
        finished = table.write(ledger, kind or table.usual())
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


def _points(plan: Plan, numbers: Sequence[int]) -> int:
    return sum(stop - first for first, stop in map(plan.part, numbers))


def _there(plan: Plan, path: Path, kind: str | None) -> Performed:
    if kind and path.suffix != f'.{kind}':
        raise InputError(
            f'{path} is complete; nothing is written twice: leave out --format, or give another '
            '--out'
        )
    return Performed(Finished(path), plan.points, 0, None, 0.0)
