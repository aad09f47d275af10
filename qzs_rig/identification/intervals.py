"""95 % intervals: from the covariance, and out to the profile where the fit is not straight.

They hold jointly: with 95 % confidence all parameters lie in theirs (Bonferroni), since they are
used together. One by one each holds with more.

The profile of a parameter is the least sum of squares with the parameter held; its interval ends
where that has risen by t² (Venzon and Moolgavkar, Appl. Statist. 37 (1988) 87).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from qzs_rig.identification.fit import Fit, minimised
from qzs_rig.identification.unknowns import Unknowns
from qzs_rig.samples import Array

BLIND = 1e-10
"""Of the largest singular value: below, the data say nothing at all about a combination."""
LEVEL = 0.95
STRAIGHT = (0.8, 1.3)
"""Rise of the sum of squares at the ends of a linear interval, over t²: within, it is left."""
FARTHEST = 4.0
"""Times the linear interval, up to where the end of a profile is looked for."""


@dataclass(frozen=True)
class Direction:
    """A combination Σ weights (p,) · Δparameter / reference that the data know to `std`, relative;
    the largest weight is 1."""

    weights: Array
    std: float


@dataclass(frozen=True)
class Covariance:
    """`matrix` (p, p) of the parameters and `plain`, (JᵀJ)⁻¹; `excess` is the factor by which given
    standard deviations were too small, squared."""

    matrix: Array
    plain: Array
    directions: tuple[Direction, ...]
    excess: float

    @property
    def std(self) -> Array:
        """Standard errors of the parameters (p,)."""
        return np.asarray(np.sqrt(np.diag(self.matrix)))

    def path(self, k: int) -> Array:
        """How all parameters (p,) follow when k is moved by its standard error and the others
        fit again."""
        return np.asarray(self.plain[:, k] * (self.std[k] / self.plain[k, k]))

    @property
    def correlation(self) -> Array:
        """Correlations of the estimates with each other (p, p)."""
        return np.asarray(self.matrix / np.outer(self.std, self.std))


@dataclass(frozen=True)
class Interval:
    """`low` to `high` hold the value with 95 % confidence, all parameters together.

    `determined` is False where the data leave it open by more than the parameter is worth; then
    the interval says only how far.
    """

    low: float
    high: float
    std: float
    determined: bool
    method: str


def covariance(fit: Fit) -> Covariance:
    """(JᵀJ)⁻¹, or where a parameter fares worse with it the robust HC3 (MacKinnon and White 1985),
    which does not ask all points to be equally noisy.

    Standard deviations that came with the measurement are widened where the fit misses by more.
    """
    scale = fit.unknowns.scale
    J, r = fit.jacobian * scale, fit.residual
    excess = max(1.0, float(r @ r) / max(fit.freedom, 1)) if fit.weighted else 1.0
    U, S, Vt = np.linalg.svd(J, full_matrices=False)
    S = np.maximum(S, BLIND * S[0])
    spread = (U * (r / np.maximum(1.0 - np.sum(U**2, axis=1), 1e-3))[:, None]) / S
    plain = (Vt.T / S**2) @ Vt
    robust = Vt.T @ (spread.T @ spread) @ Vt
    wider = np.sqrt(np.maximum(excess, np.diag(robust) / np.diag(plain)))
    units = np.outer(scale, scale)
    ways = directions(fit.unknowns, S / np.sqrt(excess), Vt)
    return Covariance(plain * np.outer(wider, wider) * units, plain * units, ways, excess)


def directions(unknowns: Unknowns, S: Array, Vt: Array) -> tuple[Direction, ...]:
    """The right singular vectors Vt (p, p) of the sensitivities per scale, best known first."""
    found = []
    references = unknowns.reference / unknowns.scale
    for s, v in zip(S.tolist(), Vt, strict=True):
        weights = v * references
        largest = weights[np.argmax(np.abs(weights))]
        found.append(Direction(weights / largest, 1.0 / (s * abs(largest))))
    return tuple(found)


def intervals(fit: Fit, known: Covariance) -> tuple[Interval, ...]:
    """The interval of each parameter, in their order."""
    from scipy.special import stdtrit

    wanted = fit.unknowns
    t = float(stdtrit(max(fit.freedom, 1), 1.0 - (1.0 - LEVEL) / (2 * len(fit.values))))
    sighted = bool(np.all(known.std <= wanted.scale))
    found = []
    for k, std in enumerate(known.std.tolist()):
        determined = bool(std <= wanted.scale[k])
        ends = [fit.values[k] - t * std, fit.values[k] + t * std]
        method = 'linear'
        # along a valley without an end the held fits would stop short, and the profile be narrow
        if sighted and not _straight(fit, known, k, t):
            low, high = (_profile_end(fit, known, k, side * t) for side in (-1.0, 1.0))
            ends, method = [min(ends[0], low), max(ends[1], high)], 'profile'
        low, high = np.clip(ends, wanted.low[k], wanted.high[k]).tolist()
        found.append(Interval(low, high, std, determined, method))
    return tuple(found)


def _straight(fit: Fit, known: Covariance, k: int, t: float) -> bool:
    """Whether the sum of squares rises by t² at both ends of the linear interval."""
    rises = [_rise(fit, known, k, fit.moved(fit.values + s * known.path(k))) for s in (-t, t)]
    return all(STRAIGHT[0] < rise / t**2 < STRAIGHT[1] for rise in rises)


def _profile_end(fit: Fit, known: Covariance, k: int, t: float) -> float:
    """Where the signed root of the profile reaches `t`."""
    from scipy.optimize import brentq

    free = np.arange(len(fit.values)) != k

    @cache
    def excess(reach: float) -> float:
        there = minimised(fit.moved(fit.values + reach * known.path(k)), free, 1e-6)
        return float(np.sqrt(max(_rise(fit, known, k, there), 0.0))) - abs(t)

    near, far = 0.0, t
    while excess(far) < 0.0 and abs(far) < FARTHEST * abs(t):
        near, far = far, 1.5 * far
    if excess(far) < 0.0:
        return float(fit.values[k] + far * known.std[k])
    reach = brentq(excess, near, far, xtol=0.02 * abs(t))
    return float(fit.values[k] + reach * known.std[k])


def _rise(fit: Fit, known: Covariance, k: int, there: Fit) -> float:
    """How much the sum of squares has risen from the fit, in the units of the interval of k."""
    rise = float(np.sum(there.penalised**2) - np.sum(fit.penalised**2))
    return rise * float(known.plain[k, k] / known.matrix[k, k])
