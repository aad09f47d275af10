"""The fit: points to branches, branches to points, until neither moves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import InputError
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
from qzs_rig.parameters import RunSpec
from qzs_rig.samples import Array
from qzs_rig.theory.oscillator import Oscillator

LEAST_NOISE = 1e-4
"""Standard deviation below which no measurement is believed, relative or in rad: windows that have
settled still differ by that."""
HARMONICS = 7
ROUNDS = 8
STEPS = 60
TOLERANCE = 1e-9
"""Share of the sum of squares that the last step still changes: far below what one standard
deviation changes it by, 1/(n - p)."""
LOST = 3.0
"""What a residual counts whose branch has ended, in standard deviations."""
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
    """The parameters `values` (p,) held against the points: a Set and the Response to it for each
    degree of freedom. Residuals are all magnitudes and phases (m,), set by set, in standard
    deviations."""

    unknowns: Unknowns
    sets: tuple[Set, ...]
    values: Array
    responses: tuple[Response, ...]

    @cached_property
    def misses(self) -> Array:
        """Residuals (m,), those too that do not count."""
        pairs = zip(self.sets, self.responses, strict=True)
        return np.concatenate([item.missed(there.ratio)[0] for item, there in pairs])

    @cached_property
    def slopes(self) -> Array:
        """Slopes of `misses` in the parameters (m, p)."""
        found = []
        for item, there in zip(self.sets, self.responses, strict=True):
            slope = sensitivity(self.unknowns, self.values, item.points, there)
            weight = item.missed(there.ratio)[1][:, None]
            found.append(-weight * np.concatenate([slope.real, slope.imag]))
        return np.concatenate(found)

    @cached_property
    def counted(self) -> NDArray[np.bool_]:
        """Which residuals (m,) are to count."""
        return np.concatenate([item.counted for item in self.sets])

    @cached_property
    def good(self) -> NDArray[np.bool_]:
        """Which of those `counted` (m,) have a motion that they are measured against."""
        met = [np.tile(there.good, 2) for there in self.responses]
        return np.asarray(self.counted & np.concatenate(met))

    @property
    def residual(self) -> Array:
        """The residuals of what is `good`."""
        return self.misses[self.good]

    @property
    def jacobian(self) -> Array:
        """Slopes of `residual` in the parameters."""
        return self.slopes[self.good]

    @property
    def penalised(self) -> Array:
        """The residuals of what is `counted`; one whose branch has ended is LOST."""
        return np.where(self.good, self.misses, LOST)[self.counted]

    @property
    def weighted(self) -> bool:
        """Whether the measurement brought its standard deviations."""
        return all(item.points.weighted for item in self.sets)

    @property
    def freedom(self) -> int:
        """Residuals beyond parameters."""
        return len(self.residual) - len(self.values)

    def moved(self, values: Array) -> Fit:
        """At other `values` (p,), brought inside their bounds, the motions followed from these;
        nothing is good where no platform can be built of them."""
        values = self.unknowns.bounded(values)
        pairs = list(zip(self.sets, self.responses, strict=True))
        try:
            spec = self.unknowns.applied(values)
            there = [_followed(spec, item.points, before) for item, before in pairs]
        except InputError:
            there = [replace(b, good=np.zeros(len(b.good), bool)) for b in self.responses]
        return Fit(self.unknowns, self.sets, values, tuple(there))


def _followed(spec: RunSpec, points: Points, before: Response) -> Response:
    """The motions of another platform; those `before` where a point has lost its branch."""
    there = followed(Oscillator.driven(spec, points.dof), points.frequency_hz, before.x)
    good = there.good & before.good
    x = np.where(good[:, None], there.x, before.x)
    return replace(there, x=x, ratio=np.where(good, there.ratio, before.ratio), good=good)


def minimised(fit: Fit, free: NDArray[np.bool_], tolerance: float) -> Fit:
    """The least sum of squares near `fit` over the parameters `free` (p,), the others held; it
    ends once a step changes the sum by less than `tolerance` of it.

    A branch may fold back before the frequency of a point: its residual then is the constant LOST,
    in all steps from there on. Motions are followed from those of the last step that was taken.
    """
    from scipy.optimize import least_squares

    if not (free.any() and fit.good.any()):
        return fit
    scale, near, at = fit.unknowns.scale[free], fit, fit

    def there(z: Array) -> Fit:
        nonlocal at
        values = fit.values.copy()
        values[free] = z * scale
        if not np.array_equal(values, at.values):
            at = near.moved(values)
        return at

    def residual(z: Array) -> Array:
        now = there(z)
        # from where there is nothing at all scipy comes back for a shorter step
        return now.penalised if now.good.any() else np.nan * now.penalised

    def slope(z: Array) -> Array:
        """Asked for only where a step was taken."""
        nonlocal near
        near = there(z)
        slopes = np.where(near.good[:, None], near.slopes[:, free] * scale, 0.0)
        return slopes[fit.counted]

    best = least_squares(
        residual,
        fit.values[free] / scale,
        slope,
        (fit.unknowns.low[free] / scale, fit.unknowns.high[free] / scale),
        ftol=tolerance,
        gtol=1e-10,
        max_nfev=STEPS,
    )
    return there(best.x)


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


def _set(points: Points, response: Response, noise: tuple[float, float], strict: bool) -> Set:
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
    item = Set(points, why, lag, noise)
    if strict:
        r, _ = item.missed(response.ratio)
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
            r = fit.misses[part][fit.good[part]] * sigma
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
