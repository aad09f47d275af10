"""One branch of steady motions over a parameter, in as many harmonics as it takes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from qzs_rig.samples import Array
from qzs_rig.theory.balance import continuation, newton
from qzs_rig.theory.balance.basis import even_part, harmonics_of, resized
from qzs_rig.theory.balance.continuation import Ending, Steps, Stop
from qzs_rig.theory.balance.newton import Equations, Point
from qzs_rig.theory.balance.stability import Stability

PATIENCE = 3
"""Numbers of harmonics in which a start may fail to converge."""


class Balance(Equations, Protocol):
    """Equations of periodic motions in so many harmonics: the unknowns x (n,) stand for
    coefficients (..., 2H + 1), p for the logarithm of a parameter.

    `ladder`: numbers of harmonics to try. More are taken while the tail of a motion is above
    `accuracy`; on the last rung it may be as large as `loosest`. `steps`: how a path is followed.
    Events are located again in more harmonics, up to `finest`; `by_determinant`: `losing` is
    as exact as the motion, so that this helps.
    """

    @property
    def harmonics(self) -> int:
        """The highest harmonic H of the motions."""

    @property
    def odd(self) -> bool:
        """Do motions mirror themselves every half period?"""

    @property
    def mirrored(self) -> bool:
        """Is a motion, upside down and half a period later, a motion, too?"""

    @property
    def ladder(self) -> tuple[int, ...]: ...
    @property
    def accuracy(self) -> float: ...
    @property
    def loosest(self) -> float: ...
    @property
    def steps(self) -> Steps: ...
    @property
    def finest(self) -> int: ...
    @property
    def by_determinant(self) -> bool: ...

    def full(self, x: Array) -> Array:
        """The coefficients of the unknowns."""

    def own(self, coefficients: Array) -> Array:
        """The unknowns of coefficients in any number of harmonics."""

    def tail(self, coefficients: Array, harmonics: int) -> float:
        """What the last two of `harmonics`, and all above, are of the motion."""

    def beyond(self, x: Array) -> Ending | None:
        """Why the equations end at this motion, or None."""

    def relative(self, values: Array, coefficients: Array) -> Array:
        """(n, 2H + 1): of n motions at `values` of the parameter, top against base along the driven
        degree of freedom."""

    def frequency(self, values: Array) -> Array:
        """Ω (n,) at `values` of the parameter."""

    def base(self, values: Array) -> Array:
        """Amplitude (n,) of the base there."""

    def stability(self, values: Array, coefficients: Array) -> Stability:
        """Of n motions in the order of their path."""

    def defect(self, values: Array, coefficients: Array) -> float:
        """The most that any of n motions leaves unbalanced in twice the harmonics, over the
        drive."""

    def losing(self, point: Point) -> float:
        """0 where a motion loses its stability other than by a fold."""

    def kind(self, point: Point) -> str:
        """The kind of that event, as in frequency_response.Event."""

    def along(self, point: Point) -> tuple[complex, complex]:
        """u/v of the fundamentals, and its slope along a path over frequency."""


Family = Callable[[int], Balance]
"""The balance in any number of harmonics."""


@dataclass(frozen=True)
class BranchProblem:
    """A motion (..., 2H + 1) at `value` of the parameter from which its branch is followed while
    the parameter stays within [low, high]. `harmonics` None adapts their number."""

    family: Family
    value: float
    coefficients: Array
    low: float
    high: float
    harmonics: int | None = None
    tolerance: float = 1e-10


@dataclass(frozen=True)
class BranchPath:
    """Motions along the path: `coefficients` (n, ..., 2H + 1) at `value` (n,) of the parameter.

    `harmonics` (n,) were needed. `ends`: why it ended at its first and its last point; with
    Stop.SYMMETRY just before it would meet a symmetric branch.
    """

    value: Array
    coefficients: Array
    harmonics: NDArray[np.int64]
    ends: tuple[Ending, Ending]


_Motions = list[tuple[float, Array]]
"""Values of the parameter, each with the coefficients of a motion."""


def follow(problem: BranchProblem) -> BranchPath:
    """Both ways from the motion of `problem`; first point towards low values."""
    start = _settled(problem)
    if start is None:
        ends = (Ending(Stop.START),) * 2
        return _followed(problem, [(problem.value, problem.coefficients)], ends)
    up, upper = _one_way(problem, *start, 1.0)
    if upper.stop is Stop.CLOSED:
        return _followed(problem, up, (upper, upper))
    down, lower = _one_way(problem, *start, -1.0)
    return _followed(problem, [*reversed(down[1:]), *up], (lower, upper))


def refined(problem: BranchProblem) -> Array | None:
    """The coefficients of `problem` in as many harmonics as it takes; None where they lead
    nowhere: it was an artefact of too few."""
    found = _settled(problem)
    return None if found is None else found[0].full(found[1])


def ends_in(path: BranchPath, value: float, x: Array, same: float) -> bool:
    """Does the path end at `value` in the motion x, to the relative distance `same`?"""
    size = max(float(np.linalg.norm(x)), 1e-12)
    for end in (0, -1):
        other = resized(path.coefficients[end], harmonics_of(x))
        near = float(np.linalg.norm(other - x)) < same * size
        if near and abs(path.value[end] / value - 1.0) < 1e-9:
            return True
    return False


def _followed(problem: BranchProblem, points: _Motions, ends: tuple[Ending, Ending]) -> BranchPath:
    most = max(harmonics_of(x) for _, x in points)
    return BranchPath(
        np.array([_bounded(value, problem) for value, _ in points]),
        np.array([resized(x, most) for _, x in points]),
        np.array([harmonics_of(x) for _, x in points]),
        ends,
    )


def _bounded(value: float, problem: BranchProblem) -> float:
    """The value, a bound exactly where it differs by the rounding of its logarithm."""
    near = min((problem.low, problem.high), key=lambda bound: abs(value - bound))
    return near if abs(value - near) < 1e-13 * near else value


def _settled(problem: BranchProblem) -> tuple[Balance, Array] | None:
    x, failures = problem.coefficients, 0
    ladder = problem.family(1).ladder if problem.harmonics is None else (problem.harmonics,)
    for harmonics in ladder:
        balance = problem.family(harmonics)
        own = newton.solve(balance, balance.own(x), math.log(problem.value), problem.tolerance, 12)
        if own is None:
            failures += 1
            if failures == PATIENCE:
                return None
            continue
        x = balance.full(own)
        if problem.harmonics is not None or balance.tail(x, harmonics) <= _bearable(balance):
            return balance, own
    return None


def _bearable(balance: Balance) -> float:
    """The largest tail of a motion in so many harmonics."""
    last = balance.harmonics == balance.ladder[-1]
    return balance.loosest if last else balance.accuracy


def _one_way(
    problem: BranchProblem, balance: Balance, x: Array, direction: float
) -> tuple[_Motions, Ending]:
    here = home = newton.start(balance, x, math.log(problem.value), direction)
    points: _Motions = []
    low, high = math.log(problem.low), math.log(problem.high)
    while True:
        most = max(1, balance.steps.most - len(points))
        steps = replace(balance.steps, tolerance=problem.tolerance, most=most)
        stop_check = partial(_stop_check, balance, problem.harmonics is None)
        path = continuation.follow(balance, here, low, high, stop_check, steps, home)
        found = path.points[:-1] if path.stop is Stop.SYMMETRY else path.points
        points += [(math.exp(q.p), balance.full(q.x)) for q in found[len(points) > 0 :]]
        if path.stop not in (Stop.MORE, Stop.FEWER):
            return points, path.ending
        place = balance.ladder.index(balance.harmonics) + (1 if path.stop is Stop.MORE else -1)
        other = problem.family(balance.ladder[min(place, len(balance.ladder) - 1)])
        last = _in_unknowns(other, balance, found[-1])
        moved = newton.correct(other, last.x, last.p, last.tangent, last.size, problem.tolerance)
        if moved is None or place == len(balance.ladder):
            detail = f'{balance.harmonics} harmonics do not suffice'
            return points, Ending(Stop.HARMONICS, detail)
        home, here, balance = _in_unknowns(other, balance, home), moved[0], other
        points[-1] = math.exp(here.p), balance.full(here.x)


def _in_unknowns(other: Balance, balance: Balance, point: Point) -> Point:
    """The `point` of one balance in the unknowns of the `other`."""
    along = newton.joined(other.own(balance.full(point.tangent[:-1])), float(point.tangent[-1]))
    x = other.own(balance.full(point.x))
    return Point(x, point.p, along / np.linalg.norm(along), point.size)


def _stop_check(balance: Balance, adapts: bool, before: Point, point: Point) -> Ending | None:
    """Ends a path where the equations end, its mirror image begins, or other harmonics are due."""
    beyond, x = balance.beyond(point.x), balance.full(point.x)
    if beyond is not None:
        return beyond
    # the even harmonics changed sign at a symmetric motion: what follows mirrors what was
    if balance.mirrored and np.vdot(even_part(balance.full(before.x)), even_part(x)) < 0:
        return Ending(Stop.SYMMETRY)
    if not adapts:
        return None
    if balance.tail(x, balance.harmonics) > _bearable(balance):
        return Ending(Stop.MORE)
    place = balance.ladder.index(balance.harmonics)
    if place and balance.tail(x, balance.ladder[place - 1]) < 0.03 * balance.accuracy:
        return Ending(Stop.FEWER)
    return None
