"""Where a branch folds, doubles its period or loses its symmetry, to the last digits.

A point between two of a path is the solution in the plane across their chord; an event is the zero
of a smooth function of the place on the chord, in so many harmonics that more do not move it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from qzs_rig.samples import Array
from qzs_rig.theory.balance import newton
from qzs_rig.theory.balance.basis import resized
from qzs_rig.theory.balance.branch import Balance, BranchPath, Family
from qzs_rig.theory.balance.newton import Equations, Point

ENOUGH = 1e-11
"""Relative change of an event's place by more harmonics that ends the search."""
CLOSE = 1e-3
"""More harmonics move an event by less than this share of the chord it lies on."""
FINE = 1e-10
"""Share of the chord to which a place on it is found; below is rounding."""


@dataclass(frozen=True)
class Stretch:
    """A piece of a branch: motions (2, ..., 2H + 1) at its ends, where the parameter has `values`
    (2,). `family` gives its equations in any number of harmonics, of which `harmonics` were needed.
    An event's place is found to the share `fine` of the chord.
    """

    family: Family
    values: Array
    coefficients: Array
    harmonics: int
    fine: float = FINE

    @staticmethod
    def of(path: BranchPath, family: Family, k: int) -> Stretch:
        """Between the points k and k + 1 of a path."""
        pair = slice(k, k + 2)
        harmonics = int(path.harmonics[pair].max())
        return Stretch(family, path.value[pair], path.coefficients[pair], harmonics)


@dataclass(frozen=True)
class Located:
    """The event `point` of `balance`; `uncertainty` is what the last harmonics moved the parameter
    by, relative, NaN where no more were tried."""

    balance: Balance
    point: Point
    uncertainty: float

    @property
    def value(self) -> float:
        """The parameter."""
        return math.exp(self.point.p)

    @property
    def coefficients(self) -> Array:
        """The motion (..., 2H + 1)."""
        return self.balance.full(self.point.x)


Zero = Callable[[Balance, Point], float]
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


def folds(path: BranchPath, family: Family) -> Iterator[tuple[int, Located]]:
    """Every fold of a path and its place."""
    for turn in turns(path.value).tolist():
        for k in (turn - 1, turn):
            located = locate(Stretch.of(path, family, k), turning)
            if located is not None:
                yield k, located
                break


def turning(balance: Balance, point: Point) -> float:
    """0 at a fold: the parameter along the path."""
    return float(point.tangent[-1])


def losing(balance: Balance, point: Point) -> float:
    """0 where a motion loses its stability other than by a fold."""
    return balance.losing(point)


def crossing(balance: Balance, point: Point) -> float:
    """0 where T = 1."""
    return math.log(abs(balance.along(point)[0]))


def topping(balance: Balance, point: Point) -> float:
    """0 where T is largest, or smallest, along a path over frequency."""
    ratio, slope = balance.along(point)
    return (ratio.conjugate() * slope).real


def zero_between(
    equations: Equations,
    here: Point,
    ahead: Point,
    function: Callable[[Point], float],
    fine: float = FINE,
) -> Point | None:
    """The point of a path between two of its points where `function` is 0, to the share `fine` of
    their chord; None where it does not change sign, or Newton does not converge on the way."""
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
        return known[brentq(value, 0.0, 1.0, xtol=fine)]
    except ValueError:  # brentq's word for both
        return None


def locate(stretch: Stretch, zero: Zero) -> Located | None:
    """The event of `zero` on a stretch; None where it does not change sign there."""
    before, now = None, locate_once(stretch, zero)
    while now is not None:
        harmonics = now.balance.harmonics
        if before is not None:
            now = Located(now.balance, now.point, abs(now.value / before.value - 1.0))
        if now.uncertainty < ENOUGH or harmonics > now.balance.finest:
            return now
        before, more = now, harmonics + max(6, 3 * harmonics // 10 // 2 * 2)
        now = locate_once(_close(stretch, now, more), zero) or locate_once(
            replace(stretch, harmonics=more), zero
        )
    return before


def _close(stretch: Stretch, located: Located, harmonics: int) -> Stretch:
    """The piece of a stretch close to what was located on it, in more harmonics."""
    side = np.array([-CLOSE, CLOSE])
    first, last = (resized(x, located.balance.harmonics) for x in stretch.coefficients)
    steps = np.multiply.outer(side, last - first)
    values = located.value * (stretch.values[1] / stretch.values[0]) ** side
    x, fine = located.coefficients + steps, FINE / (2 * CLOSE)
    return Stretch(stretch.family, values, x, harmonics, fine)


def locate_once(stretch: Stretch, zero: Zero) -> Located | None:
    """`locate` in the harmonics of the stretch, whatever more would say."""
    balance = stretch.family(stretch.harmonics)
    own = [balance.own(x) for x in stretch.coefficients]
    size = float(np.linalg.norm(own[0])) or 1.0
    blank = np.zeros(len(own[0]) + 1)
    here, ahead = (
        Point(x, math.log(value), blank, size) for x, value in zip(own, stretch.values, strict=True)
    )
    point = zero_between(balance, here, ahead, lambda point: zero(balance, point), stretch.fine)
    return None if point is None else Located(balance, point, math.nan)
