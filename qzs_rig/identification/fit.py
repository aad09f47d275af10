"""A fit: parameters held against the points, and the least squares near by."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import InputError
from qzs_rig.identification.point_response import (
    Response,
    followed,
    sensitivity,
)
from qzs_rig.identification.points import Complex, Points
from qzs_rig.identification.unknowns import Unknowns
from qzs_rig.parameters import RunSpec
from qzs_rig.samples import Array
from qzs_rig.theory.oscillator import Oscillator

STEPS = 60
LOST = 3.0
"""What a residual counts whose branch has ended, in standard deviations."""


@dataclass(frozen=True)
class DataSet:
    """The points of one degree of freedom as the fit counts them.

    `why` (n,) says why a point does not count, nothing where it does; `lag` (n,) is u/v as swept
    over settled, `noise` the standard deviation of ln T and of the phase where the points bring
    none of their own.
    """

    points: Points
    why: NDArray[np.str_]
    lag: Complex
    noise: tuple[float, float]

    def residuals(self, ratio: Complex) -> tuple[Array, Array]:
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
    """The parameters `values` (p,) held against the points: a DataSet and the Response at its
    points for each degree of freedom. Residuals are all magnitudes, then all phases of a set, set
    by set (m,), in standard deviations."""

    unknowns: Unknowns
    sets: tuple[DataSet, ...]
    values: Array
    responses: tuple[Response, ...]

    @cached_property
    def all_residuals(self) -> Array:
        """Residuals (m,), those too that do not count."""
        pairs = zip(self.sets, self.responses, strict=True)
        return np.concatenate([item.residuals(there.ratio)[0] for item, there in pairs])

    @cached_property
    def all_slopes(self) -> Array:
        """Slopes of `all_residuals` in the parameters (m, p)."""
        found = []
        for item, there in zip(self.sets, self.responses, strict=True):
            slope = sensitivity(self.unknowns, self.values, item.points, there)
            weight = item.residuals(there.ratio)[1][:, None]
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
        return self.all_residuals[self.good]

    @property
    def jacobian(self) -> Array:
        """Slopes of `residual` in the parameters."""
        return self.all_slopes[self.good]

    @property
    def penalised(self) -> Array:
        """The residuals of what is `counted`; one whose branch has ended is LOST."""
        return np.where(self.good, self.all_residuals, LOST)[self.counted]

    @property
    def weighted(self) -> bool:
        """Whether the measurement brought its standard deviations."""
        return all(item.points.weighted for item in self.sets)

    @property
    def freedom(self) -> int:
        """Degrees of freedom: residuals less parameters."""
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
        slopes = np.where(near.good[:, None], near.all_slopes[:, free] * scale, 0.0)
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
