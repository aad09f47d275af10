"""The fit: points to branches, branches to points, until neither moves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import InputError
from qzs_rig.identification.lag import swept_over_steady
from qzs_rig.identification.least_squares import TOLERANCE, Trial, minimise
from qzs_rig.identification.points import Points
from qzs_rig.identification.residuals import Set, State, evaluate, noise_of, quadratic, usual
from qzs_rig.identification.response import Response, ends_near, nearest
from qzs_rig.identification.start import ROUGH, elsewhere, starts
from qzs_rig.identification.unknowns import Unknowns
from qzs_rig.samples import Array
from qzs_rig.theory.oscillator import Oscillator

HARMONICS = 7
ROUNDS = 8
FROM = 2
"""Starts that are followed to their end."""
FULL = 0.8
"""Share of the points that a fit must account for to be a measure of the others."""
LARGEST_LAG = 0.15
"""Relative correction for the sweep up to which the first order is believed."""
OUTLIER = 8.0
"""Times the usual deviation from which a point belongs to neither branch: a transition, not noise,
even where the noise of some points is several times that of others."""

ASTRAY, FOLD, FAST = 'on no branch', 'at a fold', 'swept too fast'
"""Why a point does not count."""


@dataclass(frozen=True)
class Fit:
    """A minimum: parameters `values` (p,), the points as counted, residuals and their slopes."""

    unknowns: Unknowns
    sets: tuple[Set, ...]
    trial: Trial[State]

    @property
    def values(self) -> Array:
        """Of the parameters (p,)."""
        return self.trial.values

    @property
    def residual(self) -> Array:
        """Of what counts (m,), in standard deviations."""
        return self.trial.residual[self.trial.good]

    @property
    def jacobian(self) -> Array:
        """Slopes of `residual` (m, p)."""
        return self.trial.jacobian[self.trial.good]

    @property
    def weighted(self) -> bool:
        """Whether the measurement brought its standard deviations."""
        return all(item.points.weighted for item in self.sets)

    @property
    def freedom(self) -> int:
        """Residuals beyond parameters."""
        return len(self.residual) - len(self.values)


def fits(unknowns: Unknowns, parts: Sequence[Points], harmonics: int = HARMONICS) -> list[Fit]:
    """Every minimum found, the best first. Raises InputError where no branch meets the points."""
    found: list[Fit] = []
    left = starts(unknowns, parts)[:FROM]
    while left:
        fit = _settled(unknowns, parts, left.pop(0), harmonics)
        if fit is not None and all(_apart(fit, other) for other in found):
            left += elsewhere(unknowns, fit.values) if not found else []
            found.append(fit)
    if not found:
        raise InputError(
            'no branch of the platform passes near the measured points; check '
            'excitation.amplitude and excitation.quantity, and start nearer with --set'
        )
    yardstick = _finest(found)
    return sorted(found, key=lambda fit: cost(fit, yardstick))


def cost(fit: Fit, yardstick: Fit) -> float:
    """Sum of squares over all points, in the standard deviations of `yardstick`; what no
    branch of a fit meets counts as an outlier, so that no fit wins by leaving out."""
    total = 0.0
    for item, response, by in zip(fit.sets, fit.trial.state, yardstick.sets, strict=True):
        r, _ = replace(by, lag=item.lag).missed(response.ratio)
        there = np.concatenate([np.ones(len(item.points), bool), item.points.phased])
        met = np.tile(response.good, 2)
        capped = np.where(met, np.minimum(r**2, OUTLIER**2), OUTLIER**2)
        total += float(np.sum(capped[there]))
    return total


def _finest(found: Sequence[Fit]) -> Fit:
    """The fit of least noise among those that leave out few points: what the measurement can do."""
    most = max(len(fit.residual) for fit in found)
    full = [fit for fit in found if len(fit.residual) >= FULL * most]
    return min(full, key=lambda fit: sum(item.noise[0] for item in fit.sets))


def _settled(
    unknowns: Unknowns, parts: Sequence[Points], values: Array, harmonics: int
) -> Fit | None:
    noise: list[tuple[float, float]] = [(0.1, 0.1)] * len(parts)
    used: list[NDArray[np.bool_]] = []
    for turn in range(ROUNDS):
        responses = _responses(unknowns, parts, values, harmonics)
        sets = tuple(
            _set(points, response, level, turn > 1)
            for points, response, level in zip(parts, responses, noise, strict=True)
        )
        if sum(np.count_nonzero(item.counted) for item in sets) <= len(values):
            return None
        begin = evaluate(unknowns, sets, values, responses)
        trial = minimise(
            partial(evaluate, unknowns, sets),
            begin,
            unknowns.scale,
            unknowns.bounded,
            ROUGH if turn < 2 else TOLERANCE,
        )
        moved = np.abs(trial.values - values) / unknowns.scale
        values, noise = trial.values, noise_of(trial, sets, usual)
        same = len(used) > 0 and all(
            np.array_equal(a, item.use) for a, item in zip(used, sets, strict=True)
        )
        used = [item.use for item in sets]
        if turn > 2 and same and bool(np.all(moved < 1e-5)):
            break
    noise = noise_of(trial, sets, quadratic)
    final = tuple(replace(item, noise=level) for item, level in zip(sets, noise, strict=True))
    return Fit(unknowns, final, evaluate(unknowns, final, values, trial.state))


def _responses(
    unknowns: Unknowns, parts: Sequence[Points], values: Array, harmonics: int
) -> tuple[Response, ...]:
    spec = unknowns.applied(values)
    return tuple(
        nearest(Oscillator.driven(spec, points.dof), points, harmonics) for points in parts
    )


def _set(points: Points, response: Response, noise: tuple[float, float], strict: bool) -> Set:
    """The points that count; outliers are told once the noise is known (`strict`)."""
    why = np.full(len(points), '', dtype='<U16')
    lag = np.ones(len(points), dtype=np.complex128)
    if points.chirp.any():
        there, good = response.plant, response.good
        rate = there.omega(points.chirp[good]) / there.omega0
        lag[good] = swept_over_steady(there, response.omega[good], rate, response.x[good])
        fast = ~(np.abs(lag - 1.0) < LARGEST_LAG)
        why[fast], lag[fast] = FAST, 1.0
    why[ends_near(response, points.frequency_hz)] = FOLD
    why[~response.good] = ASTRAY
    item = Set(points, why, lag, noise)
    if strict:
        r, _ = item.missed(response.ratio)
        far = np.abs(np.where(item.counted, r, 0.0)).reshape(2, -1).max(axis=0) > OUTLIER
        why[far] = ASTRAY
    return item


def _apart(one: Fit, other: Fit) -> bool:
    return bool(np.any(np.abs(one.values - other.values) > 1e-2 * one.unknowns.scale))
