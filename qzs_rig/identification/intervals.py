"""95 % intervals: from the covariance, and out to the profile where the fit is not straight.

They hold jointly: with 95 % confidence all parameters lie in theirs (Bonferroni), since they are
used together. One by one each holds with more.

The profile of a parameter is the least sum of squares with the parameter held; its interval ends
where that has risen by t² (Venzon and Moolgavkar, Appl. Statist. 37 (1988) 87).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from qzs_rig.identification.fit import Fit, State, evaluate
from qzs_rig.identification.least_squares import Trial, minimise
from qzs_rig.identification.unknowns import Unknowns
from qzs_rig.samples import Array

BLIND = 1e-10
"""Of the largest singular value: below, the data say nothing at all about a combination."""
LEVEL = 0.95
STRAIGHT = (0.8, 1.3)
"""Rise of the sum of squares at the ends of a linear interval, over t²: within, it is left."""
LOST = 9.0
"""What a residual counts whose branch has ended: three standard deviations."""
SEARCHES = 6


@dataclass(frozen=True)
class Direction:
    """A combination Σ weights (p,) · Δparameter / reference that the data know to `std`, relative;
    the largest weight is 1."""

    weights: Array
    std: float


@dataclass(frozen=True)
class Covariance:
    """Of the parameters, (p, p), with the freedom of its variance and the factor `excess` by which
    given standard deviations were too small, squared."""

    matrix: Array
    directions: tuple[Direction, ...]
    excess: float

    @property
    def std(self) -> Array:
        """Standard errors (p,)."""
        return np.asarray(np.sqrt(np.diag(self.matrix)))

    @property
    def correlation(self) -> Array:
        """Of the estimates (p, p)."""
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
    plain = (Vt.T / S**2) @ Vt * excess
    robust = Vt.T @ (spread.T @ spread) @ Vt
    wider = np.sqrt(np.maximum(1.0, np.diag(robust) / np.diag(plain)))
    matrix = plain * np.outer(wider, wider) * np.outer(scale, scale)
    return Covariance(matrix, directions(fit.unknowns, S / np.sqrt(excess), Vt), excess)


def directions(unknowns: Unknowns, S: Array, Vt: Array) -> tuple[Direction, ...]:
    """The right singular vectors Vt (p, p) of the sensitivities per scale, best known first."""
    found = []
    references = np.array([item.reference for item in unknowns.items]) / unknowns.scale
    for s, v in zip(S.tolist(), Vt, strict=True):
        weights = v * references
        largest = weights[np.argmax(np.abs(weights))]
        found.append(Direction(weights / largest, 1.0 / (s * abs(largest))))
    return tuple(found)


def intervals(fit: Fit, known: Covariance) -> tuple[Interval, ...]:
    """One for each parameter."""
    from scipy.special import stdtrit

    t = float(stdtrit(max(fit.freedom, 1), 1.0 - (1.0 - LEVEL) / (2 * len(fit.values))))
    sighted = bool(np.all(known.std <= fit.unknowns.scale))
    found = []
    for k, (item, std) in enumerate(zip(fit.unknowns.items, known.std.tolist(), strict=True)):
        determined = std <= item.scale
        ends = [fit.values[k] - t * std, fit.values[k] + t * std]
        method = 'linear'
        # along a valley without an end the held fits would stop short, and the profile be narrow
        if sighted and not _straight(fit, known, k, t):
            low, high = (_profile_end(fit, known, k, side * t) for side in (-1.0, 1.0))
            ends, method = [min(ends[0], low), max(ends[1], high)], 'profile'
        low, high = np.clip(ends, item.low, item.high).tolist()
        found.append(Interval(low, high, std, determined, method))
    return tuple(found)


def _straight(fit: Fit, known: Covariance, k: int, t: float) -> bool:
    """Whether the sum of squares rises by t² at both ends of the linear interval."""
    shift = _path(fit, k)[0] * known.std[k] * t
    for side in (-1.0, 1.0):
        values = fit.unknowns.bounded(fit.values + side * shift)
        there = evaluate(fit.unknowns, fit.sets, values, fit.trial.state)
        if not STRAIGHT[0] < _rise(fit, known, k, there) / t**2 < STRAIGHT[1]:
            return False
    return True


def _profile_end(fit: Fit, known: Covariance, k: int, t: float) -> float:
    """Where the signed root of the profile reaches `t`, by secants from the linear end."""
    std = float(known.std[k])
    shift = _path(fit, k)[0] * std
    tried = {0.0: 0.0}
    reach, state = abs(t), fit.trial.state
    for _ in range(SEARCHES):
        begin = fit.unknowns.bounded(fit.values + np.sign(t) * reach * shift)
        trial = _held(fit, k, begin, state)
        root = np.sqrt(max(_rise(fit, known, k, trial), 0.0))
        tried[reach] = float(root)
        if abs(root - abs(t)) < 0.02 * abs(t):
            break
        reach = _next(tried, abs(t))
    return float(fit.values[k] + np.sign(t) * reach * std)


def _next(tried: dict[float, float], wanted: float) -> float:
    """The next reach: between the two that enclose `wanted`, else outward by what is missing."""
    under = max((x for x, y in tried.items() if y <= wanted), default=0.0)
    over = min((x for x, y in tried.items() if y > wanted and x > under), default=np.inf)
    if np.isinf(over):
        return under * min(max(wanted / max(tried[under], 1e-3), 1.1), 2.0)
    share = (wanted - tried[under]) / (tried[over] - tried[under])
    return under + float(np.clip(share, 0.1, 0.9)) * (over - under)


def _held(fit: Fit, k: int, values: Array, state: State) -> Trial[State]:
    """The least sum of squares with parameter k held at its place in `values`."""
    free = np.arange(len(values)) != k

    def held(others: Array, near: State) -> Trial[State]:
        whole = values.copy()
        whole[free] = others
        trial = evaluate(fit.unknowns, fit.sets, fit.unknowns.bounded(whole), near)
        return Trial(others, trial.residual, trial.jacobian[:, free], trial.good, trial.state)

    if not free.any():
        return held(values[free], state)

    def inside(others: Array) -> Array:
        whole = values.copy()
        whole[free] = others
        return np.asarray(fit.unknowns.bounded(whole)[free])

    begin = held(values[free], state)
    return minimise(held, begin, fit.unknowns.scale[free], inside, 1e-6)


def _rise(fit: Fit, known: Covariance, k: int, there: Trial[State]) -> float:
    """How much the sum of squares has risen from the fit, in the units of the interval of k."""
    counted = fit.trial.good
    lost = counted & ~there.good
    both = counted & there.good
    rise = float(np.sum(there.residual[both] ** 2) - np.sum(fit.trial.residual[both] ** 2))
    rise += LOST * float(np.count_nonzero(lost))
    return rise / (float(known.matrix[k, k]) * _path(fit, k)[1])


def _path(fit: Fit, k: int) -> tuple[Array, float]:
    """How all parameters (p,) follow when k is moved by 1 and the others fit again, and how much
    the sum of squares rises by that: 1 / [(JᵀJ)⁻¹]kk."""
    scale = fit.unknowns.scale
    J, free = fit.jacobian * scale, np.arange(len(scale)) != k
    path = np.zeros(len(scale))
    path[k] = 1.0
    path[free] = -np.linalg.lstsq(J[:, free], J[:, k], rcond=None)[0]
    return path * scale / scale[k], float(np.sum((J @ path) ** 2)) / float(scale[k] ** 2)
