"""Steady motions at one frequency, and folds over all, while amplitude, damping or a ratio of the
design varies.

A fold is a motion x with a disturbance φ that its balance does not feel, R(x, Ω) = 0 and
R_x φ = 0; both are followed over the second parameter, round the cusps where folds meet (Krack
and Gross 2019, section 4.5; Govaerts 2000).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from qzs_rig.errors import InputError
from qzs_rig.samples import Array
from qzs_rig.theory.balance import continuation, newton
from qzs_rig.theory.balance.basis import harmonics_of, lopsided, symmetric
from qzs_rig.theory.balance.branch import (
    BranchPath,
    BranchProblem,
    Family,
    ends_in,
    follow,
    refined,
)
from qzs_rig.theory.balance.continuation import Ending, Steps, Stop
from qzs_rig.theory.balance.frequency_response import Branch, Event, branch_of, frequency_response
from qzs_rig.theory.balance.harmonic_balance import VARIED, HarmonicBalance, with_value
from qzs_rig.theory.balance.newton import Point, one_thread
from qzs_rig.theory.balance.search import one_term
from qzs_rig.theory.balance.stability import stiffness
from qzs_rig.theory.oscillator import Oscillator

LEVELS = 5
"""Values of the parameter at which folds are looked for."""
SAME = 1e-5
"""Relative distance of two motions below which they are one."""


@dataclass(frozen=True)
class VariedResponse:
    """All branches at `omega` over `parameter` that reach one of its bounds, and their events."""

    oscillator: Oscillator
    parameter: str
    omega: float
    branches: tuple[Branch, ...]
    events: tuple[Event, ...]


@one_thread
def varied_response(
    oscillator: Oscillator, omega: float, parameter: str, low: float, high: float
) -> VariedResponse:
    """Motions at `omega` for `parameter` (one of VARIED) within [low, high].

    Raises InputError for another parameter, and for a range that does not rise from above 0.
    """
    _check(parameter, low, high)
    found: list[tuple[BranchPath, Family]] = []
    for value in (high, low):
        at = with_value(oscillator, parameter, value)
        for _, x in one_term(at, np.array([omega])):
            family = partial(HarmonicBalance, at, parameter=parameter, omega=omega)
            problem = BranchProblem(family, value, x, low, high)
            start = refined(problem)
            if start is None or any(ends_in(path, value, start, SAME) for path, _ in found):
                continue
            family = partial(family, odd=symmetric(at) and lopsided(start) < 1e-6)
            found.append((follow(replace(problem, family=family, coefficients=start)), family))
    read = [branch_of(path, family, number) for number, (path, family) in enumerate(found)]
    return VariedResponse(
        oscillator,
        parameter,
        omega,
        tuple(branch for branch, _ in read),
        tuple(event for _, events in read for event in events),
    )


def _check(parameter: str, low: float, high: float) -> None:
    if parameter not in VARIED:
        raise InputError(f'unknown parameter {parameter!r}; known: {", ".join(VARIED)}')
    if not 0.0 < low < high < math.inf:
        raise InputError(f'{parameter} {low:g}:{high:g}: give a range that rises from above 0')


@dataclass(frozen=True)
class FoldCurve:
    """Folds `omega` (n,) with `T` and `amplitude` of the motion, while the parameter has
    `value` (n,); both may turn back. `ends`: why it ends at its first and last point."""

    value: Array
    omega: Array
    T: Array
    amplitude: Array
    ends: tuple[Ending, Ending]


@dataclass(frozen=True)
class Folds:
    """R and R_x φ over the logarithm of the parameter; unknowns are x, φ (scaled as x) and ln Ω."""

    oscillator: Oscillator
    parameter: str
    harmonics: int
    size: float

    def linearised(self, y: Array, p: float) -> tuple[Array, Array, Array]:
        """See newton.Equations."""
        n = 2 * self.harmonics + 1
        x, phi, omega = y[:n], y[n : 2 * n], math.exp(min(float(y[-1]), 50.0))
        balance = self._balance(p)
        residual, jacobian, slope = balance.slopes(x, omega)
        matrix = np.zeros((2 * n + 1, 2 * n + 1))
        matrix[:n, :n] = matrix[n : 2 * n, n : 2 * n] = jacobian
        matrix[n : 2 * n, :n] = _curvature(balance, x, phi)
        matrix[:n, -1] = slope
        matrix[n : 2 * n, -1] = _linear_slope(balance, omega) @ phi
        matrix[-1, n : 2 * n] = 2 * phi
        ahead, behind = (self._residual(x, phi, omega, p + side) for side in (1e-5, -1e-5))
        along = np.append((ahead - behind) / 2e-5, 0.0)
        right = np.concatenate([residual, jacobian @ phi, [phi @ phi - self.size**2]])
        return right, matrix, along

    def _residual(self, x: Array, phi: Array, omega: float, p: float) -> Array:
        residual, jacobian, _ = self._balance(p).slopes(x, omega)
        return np.concatenate([residual, jacobian @ phi])

    def _balance(self, p: float) -> HarmonicBalance:
        at = with_value(self.oscillator, self.parameter, math.exp(min(p, 50.0)))
        return HarmonicBalance(at, self.harmonics)


@one_thread
def jump_map(
    oscillator: Oscillator,
    parameter: str,
    bounds: tuple[float, float],
    low: float,
    high: float,
    *,
    progress: Callable[[float, str], None] | None = None,
) -> tuple[FoldCurve, ...]:
    """Curves of folds for `parameter` within `bounds` and Ω within [low, high].

    They start from the folds at a few values of the parameter. Raises InputError for an unknown
    parameter and for bounds that do not rise from above 0.
    """
    _check(parameter, *bounds)
    found: list[FoldCurve] = []
    levels = np.geomspace(*bounds, LEVELS + 2)[1:-1]
    for k, value in enumerate(levels):
        if progress:
            progress(k / LEVELS, f'folds at {parameter} = {value:.3g}')
        at = with_value(oscillator, parameter, float(value))
        for fold in frequency_response(at, low, high).folds:
            if not any(_on(curve, float(value), fold.omega) for curve in found):
                curve = _followed(at, parameter, float(value), fold, bounds, (low, high))
                found += [] if curve is None else [curve]
    return tuple(found)


def _followed(
    oscillator: Oscillator,
    parameter: str,
    value: float,
    fold: Event,
    bounds: tuple[float, float],
    omega: tuple[float, float],
) -> FoldCurve | None:
    harmonics = harmonics_of(fold.coefficients)
    size = float(np.linalg.norm(fold.coefficients))
    equations = Folds(oscillator, parameter, harmonics, size)
    jacobian = HarmonicBalance(oscillator, harmonics).jacobian(fold.coefficients, fold.omega)
    null = np.linalg.svd(jacobian)[2][-1] * size
    y = np.concatenate([fold.coefficients, null, [math.log(fold.omega)]])
    start = newton.solve(equations, y, math.log(value))
    if start is None:
        return None

    def inside(point: Point) -> bool:
        return bool(omega[0] <= math.exp(point.x[-1]) <= omega[1])

    def stop_check(_: Point, point: Point) -> Ending | None:
        return None if inside(point) else Ending(Stop.RANGE)

    low, high = math.log(bounds[0]), math.log(bounds[1])
    path = continuation.both_ways(
        equations, start, math.log(value), low, high, stop_check, Steps(first=0.01)
    )
    points = [point for point in path.points if inside(point)]
    if len(points) < 2:
        return None
    values, frequencies = (np.exp([q.p for q in points]), np.exp([q.x[-1] for q in points]))
    w = np.array([q.x[1] - 1j * q.x[2] for q in points])
    base = [
        with_value(oscillator, parameter, float(v)).base(f)
        for v, f in zip(values, frequencies, strict=True)
    ]
    return FoldCurve(values, frequencies, np.abs(1.0 + w / base), np.abs(w), path.ends)


def _on(curve: FoldCurve, value: float, omega: float) -> bool:
    """Does the curve pass this fold?"""
    a, b = curve.value[:-1], curve.value[1:]
    for k in np.flatnonzero((np.minimum(a, b) <= value) & (value <= np.maximum(a, b))):
        share = (value - a[k]) / (b[k] - a[k] or 1.0)
        there = curve.omega[k] + share * (curve.omega[k + 1] - curve.omega[k])
        # chords of a curve that turns by 0.2 a step
        if abs(there / omega - 1.0) < 0.2 * abs(curve.omega[k + 1] / curve.omega[k] - 1.0) + 1e-4:
            return True
    return False


def _curvature(balance: HarmonicBalance, x: Array, phi: Array) -> Array:
    """Slope in x of R_x φ: the stiffness's own slope, by a central difference, along φ."""
    w, along = balance.basis.to_time @ x, balance.basis.to_time @ phi
    h = 1e-5 * max(float(np.abs(w).max()), 1e-6)
    own = balance.oscillator
    bend = (stiffness(own, w + h) - stiffness(own, w - h)) / (2 * h)
    return balance.basis.tangent(bend * along)


def _linear_slope(balance: HarmonicBalance, omega: float) -> Array:
    """Slope in ln Ω of the linear part."""
    rates = balance.basis.rates
    spin = 2 * balance.oscillator.zeta * omega * balance.basis.derivative
    return np.asarray(spin - 2 * np.diag((omega * rates) ** 2))
