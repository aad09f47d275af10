"""Where a branch folds, doubles its period or loses its symmetry, to the last digits.

A point between two of a path is the solution in the plane across their chord; an event is the zero
of a smooth function of the place on the chord, in so many harmonics that more do not move it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from qzs_rig.samples import Array
from qzs_rig.theory.balance import newton
from qzs_rig.theory.balance.basis import resized
from qzs_rig.theory.balance.harmonic_balance import BalanceEquations, transmissibility
from qzs_rig.theory.balance.newton import Equations, Point
from qzs_rig.theory.balance.stability import determinants

Found = TypeVar('Found')

ENOUGH = 1e-11
"""Relative change of an event's frequency by more harmonics that ends the search."""


@dataclass(frozen=True)
class Stretch:
    """A piece of a branch: motions (2, 2H + 1) at its ends, where the parameter has `values` (2,).

    `unknowns` gives its equations in any number of harmonics, of which `harmonics` were needed.
    """

    unknowns: Callable[[int], BalanceEquations]
    values: Array
    coefficients: Array
    harmonics: int


@dataclass(frozen=True)
class Located:
    """A motion `coefficients` (2H + 1,) where the parameter has the value `omega`; `uncertainty` is
    what the last harmonics moved that by, relative."""

    omega: float
    coefficients: Array
    uncertainty: float


Zero = Callable[[BalanceEquations, Point], float]
"""Function of a point that is 0 at the event."""


def turns(values: Array) -> NDArray[np.intp]:
    """Places (k,) inside `values` (n,) where they turn back."""
    rising = np.diff(values) > 0
    return np.flatnonzero(rising[:-1] != rising[1:]) + 1


def falls(omega: Array, T: Array, stable: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Places (k,) after which T of stable motion falls below 1 as the frequency rises."""
    above, rising = T > 1.0, np.diff(omega) > 0
    down = np.where(rising, above[:-1] & ~above[1:], ~above[:-1] & above[1:])
    return np.flatnonzero(down & stable[:-1] & stable[1:])


def folds(values: Array, at: Callable[[int], Found | None]) -> Iterator[tuple[int, Found]]:
    """Every fold of a path over `values` (n,) and its place; `at(k)` locates one between the
    points k and k + 1."""
    for k in turns(values).tolist():
        located = at(k - 1)
        place, located = (k - 1, located) if located is not None else (k, at(k))
        if located is not None:
            yield place, located


def zero_between(
    equations: Equations, here: Point, ahead: Point, function: Callable[[Point], float]
) -> Point | None:
    """The point of a path between two of its points where `function` is 0; None where it does not
    change sign, or Newton does not converge on the way."""
    from scipy.optimize import brentq

    known: dict[float, Point] = {}

    def value(share: float) -> float:
        nearest = min(known.items(), key=lambda at: abs(at[0] - share), default=None)
        point = newton.between(equations, here, ahead, share, nearest)
        if point is None:
            return math.nan
        known[share] = point
        return function(point)

    try:
        return known[brentq(value, 0.0, 1.0, xtol=1e-11)]
    except ValueError:  # brentq's word for both
        return None


def turning(unknowns: BalanceEquations, point: Point) -> float:
    """0 at a fold: the parameter along the path."""
    return float(point.tangent[-1])


def doubling(unknowns: BalanceEquations, point: Point) -> float:
    """0 at a period doubling, or in odd harmonics at a symmetry breaking."""
    oscillator, omega = unknowns.at(point.p)
    return determinants(oscillator, omega, unknowns.full(point.x), unknowns.odd)[1]


def crossing(unknowns: BalanceEquations, point: Point) -> float:
    """0 where T = 1."""
    oscillator, omega = unknowns.at(point.p)
    x = unknowns.full(point.x)
    return float(np.log(np.abs(transmissibility(oscillator, np.array([omega]), x[None])[0])))


def topping(unknowns: BalanceEquations, point: Point) -> float:
    """0 where T is largest, or smallest, along a path over frequency."""
    oscillator, omega = unknowns.at(point.p)
    x, step = unknowns.full(point.x), point.size * unknowns.full(point.tangent[:-1])
    base, rise = float(oscillator.base(omega)), float(point.tangent[-1])
    w, move = complex(x[1], -x[2]) / base, complex(step[1], -step[2]) / base
    return float(((1.0 + w).conjugate() * (move + oscillator.falloff * rise * w)).real)


def locate(stretch: Stretch, zero: Zero) -> Located | None:
    """The event of `zero` on a stretch; None where it does not change sign there."""
    harmonics, before = stretch.harmonics, None
    while True:
        now = locate_once(stretch, zero, harmonics)
        if now is None:
            return before
        change = math.inf if before is None else abs(now.omega / before.omega - 1.0)
        now = Located(now.omega, now.coefficients, change)
        if change < ENOUGH or harmonics > 160:
            return now
        before, harmonics = now, harmonics + max(6, 3 * harmonics // 10 // 2 * 2)


def locate_once(stretch: Stretch, zero: Zero, harmonics: int) -> Located | None:
    """`locate` in so many harmonics, whatever more would say."""
    equations = stretch.unknowns(harmonics)
    own = [equations.own(x) for x in stretch.coefficients]
    size = float(np.linalg.norm(own[0])) or 1.0
    blank = np.zeros(len(own[0]) + 1)
    here, ahead = (
        Point(x, math.log(value), blank, size) for x, value in zip(own, stretch.values, strict=True)
    )
    point = zero_between(equations, here, ahead, lambda point: zero(equations, point))
    if point is None:
        return None
    return Located(math.exp(point.p), resized(equations.full(point.x), harmonics), math.inf)
