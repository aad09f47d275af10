"""Every minimum of a fit: points to branches, branches to points, until neither moves.

It begins with the parameters that leave the measured motions least unbalanced. Put into the
balance, a measured motion leaves an error that is smooth in the parameters whether or not a branch
passes there: there is nothing to fall off. Noise biases its minimum a little, so it only starts the
fit of the curves (the equation error of system identification).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from qzs_rig.errors import InputError
from qzs_rig.identification.fit import DataSet, Fit, minimised
from qzs_rig.identification.point_response import (
    Response,
    centred,
    ends_near,
    nearest,
    ratios,
    swept_over_steady,
)
from qzs_rig.identification.points import Points
from qzs_rig.identification.unknowns import TRIM, Unknowns
from qzs_rig.parameters import RunSpec
from qzs_rig.samples import Array
from qzs_rig.theory.balance.harmonic_balance import HarmonicBalance
from qzs_rig.theory.oscillator import Oscillator

LEAST_NOISE = 1e-4
"""Standard deviation below which no measurement is believed, relative or in rad: windows that have
settled still differ by that."""
HARMONICS = 7
ROUNDS = 8
TOLERANCE = 1e-9
"""Share of the sum of squares that the last step still changes: far below what one standard
deviation changes it by, 1/(n - p)."""
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
TRIMS = (-0.01, 0.01)
"""Of the payload: a curve is nearly the same for more weight and for less, so both are tried."""
ROUGH = 1e-4
"""Share of the sum of squares at which the search may end."""


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
    for item, response, by in zip(fit.sets, fit.responses, yardstick.sets, strict=True):
        r, _ = replace(by, lag=item.lag).residuals(response.ratio)
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
    before: Fit | None = None
    for turn in range(ROUNDS):
        spec = unknowns.applied(values)
        plants = [Oscillator.driven(spec, points.dof) for points in parts]
        responses = tuple(map(nearest, plants, parts, [harmonics] * len(parts)))
        sets = tuple(
            _set(points, response, level, turn > 1)
            for points, response, level in zip(parts, responses, noise, strict=True)
        )
        begin = Fit(unknowns, sets, values, responses)
        if np.count_nonzero(begin.counted) <= len(values):
            return None
        fit = minimised(begin, np.ones(len(values), bool), ROUGH if turn < 2 else TOLERANCE)
        moved = np.abs(fit.values - values) / unknowns.scale
        values, noise = fit.values, _noise(fit, usual)
        same = before is not None and np.array_equal(before.counted, fit.counted)
        if turn > 2 and same and bool(np.all(moved < 1e-5)):
            break
        before = fit
    noise = _noise(fit, quadratic)
    final = tuple(replace(item, noise=level) for item, level in zip(sets, noise, strict=True))
    return replace(fit, sets=final)


def _set(points: Points, response: Response, noise: tuple[float, float], strict: bool) -> DataSet:
    """The points that count; with `strict`, once the noise is known, outliers do not."""
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
    item = DataSet(points, why, lag, noise)
    if strict:
        r, _ = item.residuals(response.ratio)
        far = np.abs(np.where(item.counted, r, 0.0)).reshape(2, -1).max(axis=0) > OUTLIER
        why[far] = ASTRAY
    return item


def _apart(one: Fit, other: Fit) -> bool:
    return bool(np.any(np.abs(one.values - other.values) > 1e-2 * one.unknowns.scale))


def _noise(fit: Fit, spread: Callable[[Array], float]) -> list[tuple[float, float]]:
    """Standard deviations of ln T and phase of each set, by its residuals."""
    parameters = len(fit.values)
    spent = 1.0 - parameters / max(len(fit.residual), parameters + 1)
    found, at = [], 0
    for item in fit.sets:
        pair = []
        for sigma in item.noise:
            part = slice(at, at + len(item.points))
            r = fit.all_residuals[part][fit.good[part]] * sigma
            level = spread(r) / spent**0.5 if r.size else 1.0
            pair.append(max(level, LEAST_NOISE))
            at += len(item.points)
        found.append((pair[0], pair[1]))
    return found


def usual(r: Array) -> float:
    """Standard deviation by the median, which transitions and free vibration do not widen."""
    return float(1.4826 * np.median(np.abs(r)))


def quadratic(r: Array) -> float:
    """Standard deviation of residuals by their root mean square."""
    return float(np.sqrt(np.mean(r**2)))


def elsewhere(unknowns: Unknowns, values: Array) -> list[Array]:
    """Where else a minimum like `values` (p,) may lie: as much weight too little as there is too
    much, or a good deal either way; nowhere without a fitted trim."""
    if TRIM not in unknowns.names:
        return []
    k, m = unknowns.names.index(TRIM), unknowns.spec.number('platform.m')
    found = []
    for trim in (-values[k], *(share * m for share in TRIMS)):
        found.append(values.copy())
        found[-1][k] = trim
    return found


def idle(unknowns: Unknowns, parts: Sequence[Points]) -> list[str]:
    """Names of the unknowns that do not enter the balance of the measured motions at all."""
    slopes = unknowns.slopes(lambda spec: _errors(spec, parts), unknowns.start)
    return [name for name, slope in zip(unknowns.names, slopes, strict=True) if not slope.any()]


def starts(unknowns: Unknowns, parts: Sequence[Points]) -> list[Array]:
    """Parameters (p,) to fit the curves from, the best balanced first, each but once."""
    from scipy.optimize import least_squares

    scale = unknowns.scale
    bounds = (unknowns.low / scale, unknowns.high / scale)
    found = []
    for begin in (unknowns.start, *elsewhere(unknowns, unknowns.start)[1:]):
        best = least_squares(
            lambda z: _errors(unknowns.applied(z * scale), parts),
            unknowns.bounded(begin) / scale,
            '3-point',
            bounds,
            ftol=ROUGH,
        )
        found.append((best.cost, unknowns.bounded(best.x * scale)))
    kept: list[Array] = []
    for _, values in sorted(found, key=lambda pair: pair[0]):
        if all(np.any(np.abs(values - k) > 0.05 * unknowns.scale) for k in kept):
            kept.append(values)
    return kept


def _errors(spec: RunSpec, parts: Sequence[Points]) -> Array:
    """What one harmonic and the mean leave unbalanced, over the drive and 0.1 + T."""
    errors = []
    for points in parts:
        there = Oscillator.driven(spec, points.dof)
        omega, balance = there.omega(points.frequency_hz), HarmonicBalance(there, 1)
        candidates = []
        motions = [m for ratio in ratios(there, points) for m in centred(there, omega, ratio)]
        for x in motions:
            left = balance.residual(x, omega)[:, 1:]
            weight = there.drive(omega) * (0.1 + points.magnitude)
            candidates.append(left / weight[:, None])
        errors.append(_smaller(candidates).ravel())
    return np.nan_to_num(np.concatenate(errors), nan=1e3, posinf=1e3, neginf=-1e3)


def _smaller(candidates: Sequence[Array]) -> Array:
    """Of each row (n, 2) the candidate that is smaller."""
    size = np.array([np.sum(c**2, axis=1) for c in candidates])
    return np.asarray(np.stack(candidates)[np.argmin(size, axis=0), np.arange(size.shape[1])])
