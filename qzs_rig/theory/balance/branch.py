"""One branch of steady motions over a parameter, in as many harmonics as it takes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from qzs_rig.samples import Array
from qzs_rig.theory.balance import continuation, newton
from qzs_rig.theory.balance.basis import even_part, harmonics_of, resized, symmetric
from qzs_rig.theory.balance.continuation import Ending, Steps, Stop
from qzs_rig.theory.balance.harmonic_balance import BalanceEquations, value_of
from qzs_rig.theory.balance.newton import Point
from qzs_rig.theory.oscillator import Oscillator

LADDER = (7, 11, 15, 21, 29, 41, 57, 79, 111, 155)
"""Numbers of harmonics that are tried."""
TAIL = 1e-8
"""The last two harmonics over all, above which more are taken."""
PATIENCE = 3
"""Numbers of harmonics in which a start may fail to converge."""
MOST = 1500
"""Points of a branch in either direction."""
FURTHEST = 1e3
"""Motion in L20 or rad, over max(1, Ĥ), at which a branch counts as unbounded."""


@dataclass(frozen=True)
class BranchProblem:
    """A motion (2H + 1,) at `omega` from which its branch is followed while `parameter`, the
    frequency or another of PARAMETERS, stays within [low, high].

    `harmonics` None adapts their number; `odd` keeps to the odd ones (of an odd law).
    """

    oscillator: Oscillator
    omega: float
    coefficients: Array
    low: float
    high: float
    odd: bool = False
    harmonics: int | None = None
    tolerance: float = 1e-10
    parameter: str = 'omega'

    @property
    def value(self) -> float:
        """Where the parameter is at the start."""
        return value_of(self.oscillator, self.omega, self.parameter)

    def unknowns(self, harmonics: int) -> BalanceEquations:
        """The equations in so many harmonics."""
        return BalanceEquations(self.oscillator, harmonics, self.odd, self.parameter, self.omega)


@dataclass(frozen=True)
class BranchPath:
    """Motions along the path: `coefficients` (n, 2H + 1) where the parameter is `omega` (n,).

    `harmonics` (n,) were needed. `ends`: why it ended at its first and its last point; with
    Stop.SYMMETRY just before it would meet a symmetric branch.
    """

    omega: Array
    coefficients: Array
    harmonics: NDArray[np.int64]
    ends: tuple[Ending, Ending]


_Motions = list[tuple[float, Array]]
"""Values of the parameter, each with a motion (2H + 1,)."""


def follow(problem: BranchProblem) -> BranchPath:
    """Both ways from the motion of `problem`; first point towards low frequency."""
    start = _settled(problem)
    if start is None:
        ends = (Ending(Stop.START),) * 2
        return _followed(problem, [(problem.value, problem.coefficients)], ends)
    up, upper = _one_way(problem, *start, 1.0)
    if upper.stop is Stop.CLOSED:
        return _followed(problem, up, (upper, upper))
    down, lower = _one_way(problem, *start, -1.0)
    return _followed(problem, [*reversed(down[1:]), *up], (lower, upper))


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


def refined(problem: BranchProblem) -> Array | None:
    """The coefficients (2H + 1,) of `problem` in as many harmonics as it takes; None where they
    lead nowhere: it was an artefact of too few."""
    found = _settled(problem)
    return None if found is None else found[0].full(found[1])


def _settled(problem: BranchProblem) -> tuple[BalanceEquations, Array] | None:
    x, failures = problem.coefficients, 0
    for harmonics in LADDER if problem.harmonics is None else (problem.harmonics,):
        equations = problem.unknowns(harmonics)
        own = newton.solve(
            equations, equations.own(x), math.log(problem.value), problem.tolerance, 12
        )
        if own is None:
            failures += 1
            if failures == PATIENCE:
                return None
            continue
        x = equations.full(own)
        if problem.harmonics is not None or _tail(x, harmonics) <= TAIL:
            return equations, own
    return None


def _one_way(
    problem: BranchProblem, equations: BalanceEquations, x: Array, direction: float
) -> tuple[_Motions, Ending]:
    here = home = newton.start(equations, x, math.log(problem.value), direction)
    points: _Motions = []
    bounds, stop_check = (math.log(problem.low), math.log(problem.high)), _StopCheck(problem)
    while True:
        stop_check.equations = equations
        steps = Steps(tolerance=problem.tolerance, most=max(1, MOST - len(points)))
        path = continuation.follow(
            equations, here, *bounds, stop_check, steps, _same(home, equations)
        )
        found = path.points[:-1] if path.stop is Stop.SYMMETRY else path.points
        points += [(math.exp(q.p), equations.full(q.x)) for q in found[len(points) > 0 :]]
        if path.stop not in (Stop.MORE, Stop.FEWER):
            return points, path.ending
        moved = _moved(problem, equations, found[-1], path.stop)
        if moved is None:
            detail = f'{equations.harmonics} harmonics do not suffice'
            return points, Ending(Stop.HARMONICS, detail)
        equations, here = moved
        points[-1] = math.exp(here.p), equations.full(here.x)


def _moved(
    problem: BranchProblem, equations: BalanceEquations, last: Point, stop: Stop
) -> tuple[BalanceEquations, Point] | None:
    """The same point in more or fewer harmonics."""
    place = LADDER.index(equations.harmonics) + (1 if stop is Stop.MORE else -1)
    if place >= len(LADDER):
        return None
    other = problem.unknowns(LADDER[place])
    along = np.append(other.own(equations.full(last.tangent[:-1])), last.tangent[-1])
    along /= np.linalg.norm(along)
    guess = other.own(equations.full(last.x))
    found = newton.correct(other, guess, last.p, along, last.size, problem.tolerance)
    return None if found is None else (other, found[0])


def _same(home: Point, equations: BalanceEquations) -> Point:
    """`home` in the unknowns of `equations`, to recognise it."""
    n = len(equations.balance.basis.columns)
    x, along = np.zeros(n), np.zeros(n + 1)
    k = min(n, len(home.x))
    x[:k], along[:k], along[-1] = home.x[:k], home.tangent[:k], home.tangent[-1]
    return Point(x, home.p, along, home.size)


@dataclass
class _StopCheck:
    """Ends a path where other harmonics are due, or the law ends."""

    problem: BranchProblem
    equations: BalanceEquations | None = None
    even: Array | None = None

    def __post_init__(self) -> None:
        self.mirrored = symmetric(self.problem.oscillator)

    def __call__(self, point: Point) -> Ending | None:
        problem, equations = self.problem, self.equations
        assert equations is not None
        w = np.abs(equations.balance.to_time @ point.x).max()
        if w >= 0.9999 * problem.oscillator.domain:
            detail = (
                f'law {problem.oscillator.law.name} ends at |w| = {problem.oscillator.domain:g}'
            )
            return Ending(Stop.DOMAIN, detail)
        if w > FURTHEST * max(1.0, problem.oscillator.amplitude):
            return Ending(Stop.UNBOUNDED, f'the motion grows beyond {w:.3g}')
        if self._mirrors(equations.full(point.x)):
            return Ending(Stop.SYMMETRY)
        return _due(problem, equations, point.x)

    def _mirrors(self, x: Array) -> bool:
        """Have the even harmonics changed sign since the last point? They did at the symmetric
        motion between; what follows is the branch's mirror image."""
        if self.problem.odd or not self.mirrored:
            return False
        before, self.even = self.even, even_part(x)
        if before is None:
            return False
        size = min(len(before), len(x))
        return float(before[:size] @ self.even[:size]) < 0


def _due(problem: BranchProblem, equations: BalanceEquations, x: Array) -> Ending | None:
    harmonics = equations.harmonics
    if problem.harmonics is not None:
        return None
    full = equations.full(x)
    if _tail(full, harmonics) > TAIL:
        return Ending(Stop.MORE)
    place = LADDER.index(harmonics)
    if place and _tail(full, LADDER[place - 1]) < 0.03 * TAIL:
        return Ending(Stop.FEWER)
    return None


def _tail(coefficients: Array, harmonics: int) -> float:
    """What the last two of `harmonics`, and all above, are of the whole."""
    high = float(np.linalg.norm(coefficients[2 * harmonics - 3 :]))
    return high / (float(np.linalg.norm(coefficients)) or 1.0)
