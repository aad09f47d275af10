"""Chaos told from cycles: largest Lyapunov exponents, how fast neighbouring runs part (above 0:
chaos) or meet, and bifurcation diagrams, what runs settle into as one parameter varies."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import InputError
from qzs_rig.samples import Array
from qzs_rig.theory.motion.batch import Batch
from qzs_rig.theory.motion.stroboscope import (
    Stroboscope,
    alike,
    cheapest_steps,
    joined,
    spread,
    strobe,
    strobe_within,
)

BATCHES = 32
"""Parts of a run whose scatter tells the standard error; each much longer than it remembers."""

ENOUGH = 5.0
"""Decay times 1/ζ that a run has to last before its exponent is given a sign: a disturbance may
grow for a while in any motion."""

UNDAMPED = 1000.0
"""τ that a run has to last instead where nothing decays."""

SURE = 4.0
"""Standard errors from zero at which an exponent has a sign."""

KINDS = ('periodic', 'transient', 'chaotic', 'undecided', 'lost')

VISIBLE = 1e-3
"""Distance from the cycle, in L20 or rad, at which a point shows as another in a diagram."""

SIGN_ERROR = 1e-6

EXPONENT_PERIODS, EXPONENT_BEFORE = 1600, 200


@dataclass(frozen=True)
class Exponents:
    """Largest exponent of n runs in units of 1/τ, that is of omega0.

    `value` (n,) over `periods` periods after `before` others, `error` (n,) its standard error by
    batch means, NaN for a run that was lost. The other exponent is -2ζ - value: the area in phase
    space shrinks alike everywhere. `end` (n, 2) is w and w' at the end. `enough` (n,): the run was
    long enough to tell a sign.
    """

    runs: Batch
    steps: int
    periods: int
    before: int
    value: Array
    error: Array
    end: Array
    enough: NDArray[np.bool_]

    @property
    def span(self) -> float:
        """Decay times 1/ζ that the shortest run lasted."""
        return float(np.min(self.runs.zeta * 2.0 * np.pi / self.runs.omega) * self.periods)

    @property
    def chaotic(self) -> NDArray[np.bool_]:
        """(n,) positive beyond doubt."""
        return np.asarray(self.enough & (self.value > SURE * self.error))

    @property
    def regular(self) -> NDArray[np.bool_]:
        """(n,) negative beyond doubt: the run settles into a cycle."""
        return np.asarray(self.enough & (self.value < -SURE * self.error))

    @property
    def mean(self) -> tuple[float, float]:
        """Mean over the runs with its standard error: for runs on the same attractor."""
        good = self.value[np.isfinite(self.value)]
        if not good.size:
            return math.nan, math.nan
        if good.size == 1:
            return float(good[0]), float(self.error[np.isfinite(self.value)][0])
        return float(good.mean()), float(good.std(ddof=1) / math.sqrt(good.size))


def exponents(
    runs: Batch,
    *,
    steps: int,
    periods: int = 2000,
    before: int = 100,
    workers: int | None = None,
) -> Exponents:
    """Follow a disturbance of every run over `periods`, rescaled each period, after `before`
    periods in which both run and disturbance forget their start."""
    for name, value, least in (('steps', steps, 1), ('periods', periods, BATCHES)):
        if value < least:
            raise InputError(f'{value} {name}; an exponent needs {least} or more')
    if before < 0:
        raise InputError(f'{before} periods before; give 0 or more')
    from qzs_rig.theory.motion import kernels

    n = len(runs)
    growth, end = np.empty((n, periods)), np.empty((n, 2))
    advance = kernels.advancing(runs.law, runs.number)
    period = kernels.schedule(steps)

    def part(which: slice) -> None:
        own = runs[which]
        block = kernels.block(runs.law.count, motions=2)
        pair = growth[which], end[which]
        kernels.grow(advance, block, own.table, own.numbers, period, before, *pair)

    spread(part, n, workers)
    length = 2.0 * np.pi / runs.omega
    growth[~np.isfinite(growth)] = np.nan
    value = growth.mean(axis=1) / length
    size = periods // BATCHES
    batches = growth[:, : size * BATCHES].reshape(n, BATCHES, size).mean(axis=2)
    error = batches.std(axis=1, ddof=1) / math.sqrt(BATCHES) / length
    span = length * periods
    enough = (runs.zeta * span >= ENOUGH) | ((runs.zeta == 0.0) & (span >= UNDAMPED))
    return Exponents(runs, steps, periods, before, value, error, end, enough)


@dataclass(frozen=True)
class Diagram:
    """`seen` at every value of the parameter, in the order of the runs.

    `kind` (n,): `periodic` where the run repeated itself before the kept points began;
    `transient` where these still show some of its transient, the first missing the cycle by
    `stray`, though the `exponent` (n,) is negative: it is bound for a cycle; `chaotic` where the
    exponent is positive beyond doubt; `undecided` where it is too close to zero to tell; `lost`
    where the run left its law. Exponent and standard error are NaN where nothing is in question.
    """

    seen: Stroboscope
    kind: NDArray[np.str_]
    stray: Array
    exponent: Array
    exponent_error: Array

    def count(self, kind: str) -> int:
        """Runs of a kind."""
        return int(np.count_nonzero(self.kind == kind))


def from_rest(
    runs: Batch,
    error: float = 1e-6,
    *,
    periods: int = 500,
    keep: int = 400,
    early: bool = True,
    steps: int | None = None,
) -> Diagram:
    """Every run from its own start; with `steps` unchecked in that many a period."""
    how = {'periods': periods, 'keep': keep}
    if steps is None:
        return judged(strobe_within(runs, error, early=early, **how))
    return judged(strobe(runs, steps=steps, early=early, **how))


def carried(
    runs: Batch,
    error: float = 1e-6,
    *,
    periods: int = 500,
    keep: int = 400,
    early: bool = True,
    steps: int | None = None,
    progress: Callable[[int], None] = lambda done: None,
) -> Diagram:
    """Every run from where the one before it ended, the first from its own start: a slow sweep.

    The state is not held against a finer run: `error` chooses the steps, as cheapest_steps does.
    """
    each = np.full(len(runs), steps or 0)
    if steps is None:
        for which in alike(runs):
            each[which] = cheapest_steps(runs[which], error)
    parts: list[Stroboscope] = []
    for k in range(len(runs)):
        own = runs[k : k + 1]
        # a run that was lost leaves nothing to go on from
        if parts and np.isfinite(parts[-1].end).all():
            own = own.starting(parts[-1].end[:, 0], parts[-1].end[:, 1])
        parts.append(strobe(own, steps=int(each[k]), periods=periods, keep=keep, early=early))
        progress(k + 1)
    began = runs.starting(
        np.concatenate([part.runs.w for part in parts]),
        np.concatenate([part.runs.velocity for part in parts]),
    )
    return judged(joined(parts, began))


def judged(seen: Stroboscope) -> Diagram:
    """Each run's kind; an exponent, from where the run ended, settles what is in question."""
    n = len(seen.runs)
    kind = np.full(n, 'periodic', dtype='<U9')
    kind[seen.period < 0] = 'lost'
    value, error = np.full(n, np.nan), np.full(n, np.nan)
    stray = strayed(seen)
    open_ = np.flatnonzero((seen.period == 0) | (stray > VISIBLE))
    for steps in np.unique(seen.steps[open_]):
        which = open_[seen.steps[open_] == steps]
        own = seen.runs[which].starting(seen.end[which, 0], seen.end[which, 1])
        # a sign needs no finer steps than the points do
        found = decided(own, min(int(steps), cheapest_steps(own, SIGN_ERROR)))
        value[which], error[which] = found.value, found.error
        kind[which] = np.select(
            [found.chaotic, found.regular], ['chaotic', 'transient'], 'undecided'
        )
    return Diagram(seen, kind, stray, value, error)


def decided(runs: Batch, steps: int) -> Exponents:
    """Exponents of runs, of those too close to zero over eight times as many periods."""
    found = exponents(runs, steps=steps, periods=EXPONENT_PERIODS, before=EXPONENT_BEFORE)
    open_ = np.flatnonzero(~(found.chaotic | found.regular) & np.isfinite(found.value))
    if open_.size:
        longer = exponents(
            runs[open_], steps=steps, periods=8 * EXPONENT_PERIODS, before=EXPONENT_BEFORE
        )
        found.value[open_], found.error[open_] = longer.value, longer.error
        found.enough[open_] = longer.enough
    return found


def strayed(seen: Stroboscope) -> Array:
    """(n,) how far the first kept points lie off the cycle that the run ended in; NaN without."""
    stray, keep = np.full(len(seen.runs), np.nan), seen.w.shape[1]
    for period in np.unique(seen.period[seen.period > 0]):
        which, first = np.flatnonzero(seen.period == period), np.arange(min(period, keep))
        last = first + (keep - 1 - first) // period * period
        stray[which] = np.max(
            np.abs(seen.w[np.ix_(which, first)] - seen.w[np.ix_(which, last)]), axis=1, initial=0.0
        )
    return stray
