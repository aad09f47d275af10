"""Runs seen once a period, when the base is at its highest: Poincaré's map, many at a time, in a
given number of steps or in the fewest that keep what was asked for, checked run by run."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import InputError
from qzs_rig.samples import Array
from qzs_rig.theory.motion.batch import WIDTH, Batch

LONGEST = 16
"""Periods of the longest cycle that is looked for."""

RETURN = 1e-8
"""A run has settled where what is left of its transient is below this."""

FAR = 1e6
"""|w| from which a run counts as lost where its law holds anywhere."""

LADDER = tuple(round(4.5 * 2.0 ** (k / 4.0)) for k in range(2, 29))
"""Steps a period that are tried."""

FINEST = 1e-12
"""Smallest error of w that can be asked for: sums of numbers of order 1 round off below."""

COARSER = 0.78
"""Steps of the run that checks, over those of the run that counts."""

PROBES, PROBE_PERIODS = 32, 8
WORTHWHILE = 8.0
"""Twice the steps should move w by the estimated error. Where they move it by more than this
many, the run is chaotic or sits on a border, and no step helps."""

_PER_RUN = (
    'steps', 'w', 'velocity', 'period', 'settled', 'end', 'fundamental', 'low', 'high', 'error',
)  # fmt: skip


@dataclass(frozen=True)
class Stroboscope:
    """What n runs of `runs` did, `steps` (n,) a period.

    `w` and `velocity` (n, keep) stand after each of the last `keep` of `periods`. `period` (n,) is
    1, 2, … where a run repeats itself after that many, 0 where it had not settled by the end, -1
    where it left its law's domain (the rest is NaN); `settled` (n,) is when that was found. The
    figures cover the cycle, or the last 32 periods: `end` (n, 2) w and w', `fundamental` (n,)
    complex, w = Re(fundamental e^{iΩτ}) + …, `low` and `high` (n,) of w over the steps.
    `error` (n,) is how much finer steps change w, NaN where that was not measured.
    """

    runs: Batch
    steps: NDArray[np.int64]
    periods: int
    w: Array
    velocity: Array
    period: NDArray[np.int64]
    settled: NDArray[np.int64]
    end: Array
    fundamental: NDArray[np.complex128]
    low: Array
    high: Array
    error: Array

    def __getitem__(self, which: Any) -> Stroboscope:
        """Some of the runs."""
        picked = {name: getattr(self, name)[which] for name in _PER_RUN}
        return replace(self, runs=self.runs[which], **picked)

    def put(self, which: NDArray[np.int64], part: Stroboscope) -> None:
        """Overwrite some of the runs' results."""
        for name in _PER_RUN:
            getattr(self, name)[which] = getattr(part, name)

    @property
    def transmissibility(self) -> NDArray[np.complex128]:
        """(n,) u/v of the fundamentals; its angle is the phase of the top against the base. NaN
        where the base is at rest."""
        base = np.where(self.runs.base > 0.0, self.runs.base, np.nan)
        with np.errstate(invalid='ignore'):
            return np.asarray(1.0 + self.fundamental / base)


def joined(parts: Sequence[Stroboscope], runs: Batch) -> Stroboscope:
    """Parts side by side, what `runs` did in this order."""
    fields: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in _PER_RUN
    }
    return replace(parts[0], runs=runs, **fields)


def strobe(
    runs: Batch,
    *,
    steps: int,
    periods: int = 500,
    keep: int = 400,
    early: bool = True,
    phase: float = 0.0,
    tolerance: float = RETURN,
    workers: int | None = None,
) -> Stroboscope:
    """All runs through `periods` in `steps` a period; `keep` = 0 keeps the figures only.

    With `early` a run ends where it repeats itself within `tolerance`, and the cycle found stands
    for the rest. The runs start, and are seen, where the base's phase is `phase`: 0 at its highest,
    π at its lowest. Memory: (2 keep + 16) numbers a run. `workers` threads, by default all cores.
    """
    from qzs_rig.theory.motion import cycles, kernels

    _check(steps, periods, keep)
    n, domain = len(runs), runs.law.domain[runs.number]
    found = cycles.found(n, periods, keep)
    advance = kernels.advancing(runs.law, runs.number)
    rules = cycles.Rules(periods, LONGEST, early, tolerance, float(min(domain, FAR)))
    period = kernels.schedule(steps, phase)

    def part(which: slice) -> None:
        own = runs[which]
        block, result = kernels.block(runs.law.count), found.part(which)
        cycles.settle(advance, block, own.table, own.numbers, period, rules, result)

    spread(part, n, workers)
    return Stroboscope(
        runs=runs,
        steps=np.full(n, steps),
        periods=periods,
        w=found.points[:, 0],
        velocity=found.points[:, 1],
        period=found.cycle,
        settled=found.settled,
        end=found.figures[:, :2],
        fundamental=np.asarray((found.figures[:, 2] - 1j * found.figures[:, 3]) * (2.0 / steps)),
        low=found.figures[:, 4],
        high=found.figures[:, 5],
        error=np.full(n, math.nan),
    )


def _check(steps: int, periods: int, keep: int) -> None:
    if steps < 1:
        raise InputError(f'{steps} steps a period; give 1 or more')
    if periods < 1:
        raise InputError(f'{periods} periods; give 1 or more')
    if not 0 <= keep <= periods:
        raise InputError(f'{keep} of {periods} periods kept; give 0 to {periods}')


def spread(work: Callable[[slice], None], runs: int, workers: int | None) -> None:
    """`work` on all runs, by threads: kernels let go of the interpreter's lock.

    Even parts: blocks stay full, and no worker waits long for another.
    """
    count = workers or os.cpu_count() or 1
    rounds = min(4, runs // (4 * WIDTH * count)) if count > 1 else 0
    parts = count * rounds or 1
    edges = [round(k * runs / parts) for k in range(parts + 1)]
    tasks = [slice(*pair) for pair in pairwise(edges)]
    if len(tasks) == 1:
        work(tasks[0])
        return
    with ThreadPoolExecutor(count) as pool:
        list(pool.map(work, tasks))


@dataclass(frozen=True)
class History:
    """Relative motion `w` and velocity dw/dτ at `tau`, each (periods · steps + 1,)."""

    tau: Array
    w: Array
    velocity: Array


def history(run: Batch, periods: int, steps: int, phase: float = 0.0) -> History:
    """The first of `run` over `periods`, the same numbers as `strobe` gives once a period.

    NaN from where it leaves its law's domain.
    """
    from qzs_rig.theory.motion import kernels

    if periods < 1 or steps < 1:
        raise InputError(f'{periods} periods of {steps} steps; give 1 or more of both')
    period, block = kernels.schedule(steps, phase), kernels.block(run.law.count)
    kernels.begin(block, 0, run.table, run.numbers, 0, period)
    advance, limit = kernels.advancing(run.law, run.number), run.law.domain[run.number]
    out = np.full((periods * steps + 1, 2), np.nan)
    out[0] = run.w[0], run.velocity[0]
    for k, step in enumerate(kernels.single_steps(period) * periods, start=1):
        advance(block, step)
        if not abs(block.w[0, 0]) < limit:
            break
        out[k] = block.w[0, 0], block.h[0] * block.y[0, 0]
    return History(block.h[0] * np.arange(len(out)), out[:, 0], out[:, 1])


def strobe_within(
    runs: Batch,
    error: float = 1e-6,
    *,
    periods: int = 500,
    keep: int = 400,
    early: bool = True,
    workers: int | None = None,
) -> Stroboscope:
    """`strobe` with the fewest steps that keep w within `error`, for frequencies of any spread.

    Every run is done twice, with steps in the ratio 0.78, which tells its error; those that miss
    are done again with twice the steps as long as that helps. `Stroboscope.error` is what remains
    in the kept points, or in the end state and fundamental with `keep` = 0.
    """
    if not error >= FINEST:
        raise InputError(
            f'error {error:g}; give what w may be off, {FINEST:g} or more, for instance 1e-6'
        )
    how: dict[str, Any] = {'periods': periods, 'keep': keep, 'early': early, 'workers': workers}
    how['tolerance'] = max(FINEST, min(RETURN, 0.1 * error))
    groups = alike(runs)
    parts = [_checked(runs[which], error, how) for which in groups]
    if len(parts) == 1:
        return parts[0]
    order = np.concatenate(groups)
    return joined(parts, runs[order])[np.argsort(order)]


def alike(runs: Batch) -> list[NDArray[np.int64]]:
    """Runs in groups of a third of an octave: a step that serves one frequency is too long for a
    much lower one."""
    third = np.round(np.log2(runs.omega) * 3.0)
    return [np.flatnonzero(third == group) for group in np.unique(third)]


def cheapest_steps(runs: Batch, error: float) -> int:
    """Steps a period with which three runs in four stay well within `error` at the start.

    Tried on up to 32 of the runs over eight periods.
    """
    some = runs[np.unique(np.linspace(0, len(runs) - 1, PROBES).astype(int))]
    before: Stroboscope | None = None
    for steps in LADDER:
        now = strobe(some, steps=steps, periods=PROBE_PERIODS, keep=PROBE_PERIODS, early=False)
        if before is not None:
            missed = _missed(before, now)
            if np.nanquantile(np.append(missed, 0.0), 0.75) <= 0.25 * error:
                return int(steps)
        before = now
    return int(LADDER[-1])


def _checked(runs: Batch, error: float, how: Mapping[str, Any]) -> Stroboscope:
    from qzs_rig.theory.motion import kernels

    steps = cheapest_steps(runs, error)
    coarse = strobe(runs, steps=max(2, round(COARSER * steps)), **how)
    fine = strobe(runs, steps=steps, **how)
    fine = replace(fine, error=_missed(coarse, fine))
    left = np.flatnonzero(fine.error > error)
    while left.size and steps < 16 * LADDER[-1]:
        steps *= 2
        finer = strobe(runs[left], steps=steps, **how)
        missed = _missed(fine[left], finer)
        away = missed * (2.0**kernels.ORDER - 1.0)
        helped = away < fine.error[left] * WORTHWHILE
        missed = np.where(helped, missed, away)
        fine.put(left, replace(finer, error=missed))
        left = left[helped & (missed > error)]
    return fine


def _missed(coarse: Stroboscope, fine: Stroboscope) -> Array:
    """(n,) error of `fine`, from its difference to `coarse`; NaN where both were lost alike."""
    from qzs_rig.theory.motion.kernels import ORDER

    ratio = np.max(fine.steps) / np.max(coarse.steps)
    away = np.abs(coarse.end[:, 0] - fine.end[:, 0])
    # the sums of a transient depend on where it is sampled
    repeats = (coarse.period > 0) & (fine.period > 0)
    wave = np.abs(coarse.fundamental - fine.fundamental)
    away = np.maximum(away, np.where(repeats, wave, 0.0))
    if fine.w.shape[1]:
        away = np.maximum(np.max(np.abs(coarse.w - fine.w), axis=1), away)
    return np.asarray(np.where(np.isnan(away), np.nan, away / (ratio**ORDER - 1.0)))
