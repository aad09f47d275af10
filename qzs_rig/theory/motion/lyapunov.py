"""Largest Lyapunov exponent: how fast neighbouring runs part (above 0: chaos) or meet."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import InputError
from qzs_rig.samples import Array
from qzs_rig.theory.motion.batch import Batch
from qzs_rig.theory.motion.splitting import schedule
from qzs_rig.theory.motion.stroboscope import spread

BATCHES = 32
"""Parts of a run whose scatter tells the standard error; each much longer than it remembers."""

ENOUGH = 5.0
"""Decay times 1/ζ that a run has to last before its exponent is given a sign: a disturbance may
grow for a while in any motion."""

UNDAMPED = 1000.0
"""τ that a run has to last instead where nothing decays."""

SURE = 4.0
"""Standard errors from zero at which an exponent has a sign."""


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
    period = schedule(steps)

    def part(which: slice) -> None:
        own = runs[which]
        block = kernels.block(motions=2)
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
