"""The fit: points to branches, branches to points, until neither moves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import InputError
from qzs_rig.identification.least_squares import TOLERANCE, Trial, minimise
from qzs_rig.identification.points import Complex, Points
from qzs_rig.identification.response import (
    Response,
    ends_near,
    followed,
    nearest,
    sensitivity,
    swept_over_steady,
)
from qzs_rig.identification.start import ROUGH, elsewhere, starts
from qzs_rig.identification.unknowns import Unknowns
from qzs_rig.samples import Array
from qzs_rig.theory.oscillator import Oscillator

LEAST_NOISE = 1e-4
"""Standard deviation below which no measurement is believed, relative or in rad: windows that have
settled still differ by that."""
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


State = tuple[Response, ...]


@dataclass(frozen=True)
class Set:
    """The points of one degree of freedom as the fit counts them.

    `why` (n,) says why a point does not count, nothing where it does; `lag` (n,) is u/v as swept
    over settled, `noise` the standard deviation of ln T and of the phase where the points bring
    none of their own.
    """

    points: Points
    why: NDArray[np.str_]
    lag: Complex
    noise: tuple[float, float]

    def missed(self, ratio: Complex) -> tuple[Array, Array]:
        """Residuals (2n,) of magnitude, then of phase, given u/v (n,) settled; and the weights
        (2n,) by which they fall as ln u/v grows."""
        points, shown = self.points, ratio * self.lag
        T, size = points.magnitude, np.abs(shown)
        turn = np.angle(np.exp(1j * np.nan_to_num(points.phase)) / shown)
        if points.weighted:
            r = np.concatenate([(T - size) / points.std, T * turn / points.std])
            return r, np.concatenate([size / points.std, T / points.std])
        # what the first order of the lag leaves out is about its square
        per = [1.0 / np.hypot(s, np.abs(self.lag - 1.0) ** 2) for s in self.noise]
        return np.concatenate([np.log(T / size) * per[0], turn * per[1]]), np.concatenate(per)

    def residual(self, ratio: Complex, slope: Complex) -> tuple[Array, Array]:
        """Residuals (2n,) as `missed`, and their slopes (2n, p) given that of ln u/v (n, p)."""
        r, weight = self.missed(ratio)
        return r, -weight[:, None] * np.concatenate([slope.real, slope.imag])

    @property
    def use(self) -> NDArray[np.bool_]:
        """Which points (n,) count."""
        return np.asarray(self.why == '')

    @property
    def counted(self) -> NDArray[np.bool_]:
        """Which of the residuals (2n,) there are and count."""
        return np.concatenate([self.use, self.use & self.points.phased])


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


def evaluate(unknowns: Unknowns, sets: Sequence[Set], values: Array, state: State) -> Trial[State]:
    """Residuals and slopes of all sets at `values` (p,), the motions followed from `state`.

    Nothing is good where no platform can be built of the values."""
    responses, parts = [], []
    for item, before in zip(sets, state, strict=True):
        hz, dof = item.points.frequency_hz, item.points.dof
        try:
            there = _kept(
                followed(Oscillator.driven(unknowns.applied(values), dof), hz, before.x), before
            )
            slope = sensitivity(unknowns, values, dof, there, hz)
        except InputError:
            return _nowhere(sets, values, state)
        good = there.good
        r, jacobian = item.residual(there.ratio, slope)
        parts.append((r, jacobian, item.counted & np.tile(good, 2)))
        responses.append(there)
    r, jacobian, good = (np.concatenate(column) for column in zip(*parts, strict=True))
    usable = good & np.isfinite(r) & np.isfinite(jacobian).all(axis=1)
    return Trial(values, r, jacobian, usable, tuple(responses))


def _kept(there: Response, before: Response) -> Response:
    """`there`, but with the motion of `before` where a point has lost its branch."""
    good = there.good & before.good
    x = np.where(good[:, None], there.x, before.x)
    ratio = np.where(good, there.ratio, before.ratio)
    return Response(there.plant, there.omega, x, ratio, good)


def _nowhere(sets: Sequence[Set], values: Array, state: State) -> Trial[State]:
    n = 2 * sum(len(item.points) for item in sets)
    return Trial(values, np.zeros(n), np.zeros((n, len(values))), np.zeros(n, dtype=bool), state)


def noise_of(
    trial: Trial[State], sets: Sequence[Set], spread: Callable[[Array], float]
) -> list[tuple[float, float]]:
    """Standard deviations of ln T and phase of each set, by its residuals in `trial`."""
    parameters = len(trial.values)
    spent = 1.0 - parameters / max(int(np.count_nonzero(trial.good)), parameters + 1)
    found, at = [], 0
    for item in sets:
        pair = []
        for sigma in item.noise:
            part = slice(at, at + len(item.points))
            r = trial.residual[part][trial.good[part]] * sigma
            level = spread(r) / spent**0.5 if r.size else 1.0
            pair.append(max(level, LEAST_NOISE))
            at += len(item.points)
        found.append((pair[0], pair[1]))
    return found


def usual(r: Array) -> float:
    """By the median, which transitions and free vibration do not widen."""
    return float(1.4826 * np.median(np.abs(r)))


def quadratic(r: Array) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(r**2)))
