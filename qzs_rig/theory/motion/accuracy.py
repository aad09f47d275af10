"""The cheapest steps that keep what was asked for, checked run by run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import InputError
from qzs_rig.samples import Array
from qzs_rig.theory.motion.batch import Batch
from qzs_rig.theory.motion.splitting import ORDER
from qzs_rig.theory.motion.stroboscope import RETURN, Stroboscope, joined, strobe

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
    steps = cheapest_steps(runs, error)
    coarse = _run(runs, max(2, round(COARSER * steps)), how)
    fine = _run(runs, steps, how)
    fine = replace(fine, error=_missed(coarse, fine))
    left = np.flatnonzero(fine.error > error)
    while left.size and steps < 16 * LADDER[-1]:
        steps *= 2
        finer = _run(runs[left], steps, how)
        missed = _missed(fine[left], finer)
        away = missed * (2.0**ORDER - 1.0)
        helped = away < fine.error[left] * WORTHWHILE
        missed = np.where(helped, missed, away)
        fine.put(left, replace(finer, error=missed))
        left = left[helped & (missed > error)]
    return fine


def _run(runs: Batch, steps: int, how: Mapping[str, Any]) -> Stroboscope:
    return strobe(runs, steps=steps, **how)


def _missed(coarse: Stroboscope, fine: Stroboscope) -> Array:
    """(n,) error of `fine`, from its difference to `coarse`; NaN where both were lost alike."""
    ratio = np.max(fine.steps) / np.max(coarse.steps)
    away = np.abs(coarse.end[:, 0] - fine.end[:, 0])
    # the sums of a transient depend on where it is sampled
    repeats = (coarse.period > 0) & (fine.period > 0)
    wave = np.abs(coarse.fundamental - fine.fundamental)
    away = np.maximum(away, np.where(repeats, wave, 0.0))
    if fine.w.shape[1]:
        away = np.maximum(np.max(np.abs(coarse.w - fine.w), axis=1), away)
    return np.asarray(np.where(np.isnan(away), np.nan, away / (ratio**ORDER - 1.0)))
