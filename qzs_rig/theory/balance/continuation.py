"""Pseudo-arc-length continuation of the solutions of any equations with one parameter.

Keller (1977); Krack and Gross, Harmonic Balance for Nonlinear Vibration Problems (2019),
section 4.4. Lengths are relative: motions over their own size, parameters by their logarithm.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from typing import Protocol

import numpy as np

from qzs_rig.samples import Array


class Equations(Protocol):
    """R(x, p) = 0 in as many unknowns x (n,) as equations; p is the logarithm of a parameter."""

    def linearised(self, x: Array, p: float) -> tuple[Array, Array, Array]:
        """R (n,), its slope in x (n, n) and in p (n,)."""


@dataclass(frozen=True)
class Steps:
    """How a path is followed: lengths of a step, and the angle in rad its direction may turn by.

    A step whose end lies on the other side (see Point) has jumped onto another path and is taken
    again, shorter; only below `crossing` it is believed to have passed a point where paths cross.
    """

    first: float = 0.02
    largest: float = 0.08
    smallest: float = 1e-7
    turn: float = 0.2
    most: int = 4000
    crossing: float = 1e-4
    tolerance: float = 1e-10


@dataclass(frozen=True)
class Point:
    """A solution x (n,) at p, and the unit tangent of its path: x part (n,) over `size`, then p.

    `size` is what x is measured by around here. `side` is the sign of the determinant of the slope
    with the tangent below it: the same all along a path that crosses no other.
    """

    x: Array
    p: float
    tangent: Array
    size: float
    side: float = 0.0


class Stop(Enum):
    """Criteria that end a path; the first four are no failure."""

    RANGE = 'range'
    CLOSED = 'closed'
    SYMMETRY = 'symmetry'
    AMPLITUDE = 'amplitude'
    DOMAIN = 'the law ends'
    UNBOUNDED = 'the motion grows without bound'
    TILT = 'the plate turns by more than 1 rad'
    MORE = 'more harmonics are needed'
    FEWER = 'fewer harmonics suffice'
    HARMONICS = 'harmonics do not suffice'
    START = 'the start does not converge'
    STEP = 'no further step converges'
    POINTS = 'too many points'


@dataclass(frozen=True)
class Ending:
    """Why a path ended; `detail` in words, where there is more to say."""

    stop: Stop
    detail: str = ''

    @property
    def early(self) -> bool:
        """Did something break the path off?"""
        return self.stop not in (Stop.RANGE, Stop.CLOSED, Stop.SYMMETRY, Stop.AMPLITUDE)

    def __str__(self) -> str:
        return self.detail or self.stop.value


@dataclass(frozen=True)
class Path:
    """Points in the order of the steps, and why they end."""

    points: tuple[Point, ...]
    ending: Ending

    @property
    def stop(self) -> Stop:
        """The criterion that ended it."""
        return self.ending.stop


Judge = Callable[[Point], Ending | None]
"""Looks at a new point: why the path ends with it, or None."""


def solve(
    equations: Equations, x: Array, p: float, tolerance: float = 1e-10, iterations: int = 30
) -> Array | None:
    """Newton at fixed p from x (n,); None where it does not converge."""
    x = np.array(x)
    for _ in range(iterations):
        residual, jacobian, _ = _quiet(equations, x, p)
        move = _solved(jacobian, residual)
        if move is None:
            return None
        x -= move
        size = float(np.linalg.norm(x))
        if float(np.linalg.norm(move)) <= math.sqrt(tolerance) * 0.1 * size:
            return x
    return None


def start(equations: Equations, x: Array, p: float, direction: float) -> Point:
    """The point of a solution, its tangent heading where p grows (`direction` > 0) or falls."""
    size = float(np.linalg.norm(x)) or 1.0
    _, jacobian, slope = _quiet(equations, x, p)
    # the path may run at one p: what the slopes leave out, not what p asks for
    ahead = np.linalg.svd(np.column_stack([jacobian * size, slope]))[2][-1]
    sign = ahead[-1] if abs(ahead[-1]) > 1e-9 else 1.0
    plane = math.copysign(1.0, sign * direction) * ahead
    return _located(equations, x, p, size, plane)


def correct(
    equations: Equations, guess: Array, p: float, plane: Array, size: float, tolerance: float
) -> tuple[Point, int] | None:
    """The solution nearest `guess`, p in the hyperplane across `plane`, its tangent in the half
    space of `plane`, and the iterations it took; None where Newton does not converge."""
    x, before = np.array(guess), math.inf
    goal = 0.1 * math.sqrt(tolerance)
    for iteration in range(1, 9):
        found = _newton(equations, x, p, plane, size)
        if found is None:
            return None
        move, along, side = found
        x -= size * move[:-1]
        p -= float(move[-1])
        length = _length(move)
        if length <= goal:
            # where Newton steps so little, the tangent before the step is that after it
            return Point(x, p, along, size, side), iteration
        if length > 2 * before or length > 2.0:
            return None
        before = length
    return None


def follow(
    equations: Equations,
    first: Point,
    low: float,
    high: float,
    judge: Judge = lambda _: None,
    steps: Steps = Steps(),
    origin: Point | None = None,
) -> Path:
    """From `first` along its tangent until p leaves [low, high] (the last point lies on the bound),
    the path closes at `origin`, `judge` ends it, or no step succeeds."""
    points, h = [first], steps.first
    home = origin or first
    while len(points) < steps.most:
        here = points[-1]
        before = points[-2] if len(points) > 1 else None
        ahead, h = _step(equations, before, here, h, steps)
        if ahead is None:
            return Path(tuple(points), Ending(Stop.STEP))
        if len(points) > 4 and _passed(home, here, ahead):
            return Path((*points, home), Ending(Stop.CLOSED))
        if not low <= ahead.p <= high:
            bound = low if ahead.p < low else high
            there = abs(here.p - bound) < 1e-12
            last = None if there else _at_bound(equations, here, ahead, bound, steps)
            return Path((*points, last) if last else tuple(points), Ending(Stop.RANGE))
        points.append(ahead)
        ending = judge(ahead)
        if ending:
            return Path(tuple(points), ending)
    return Path(tuple(points), Ending(Stop.POINTS, f'{steps.most} points'))


@dataclass(frozen=True)
class WholePath:
    """Points from the low end of a path to its high one, and why it ends at either."""

    points: tuple[Point, ...]
    ends: tuple[Ending, Ending]


def both_ways(
    equations: Equations,
    x: Array,
    p: float,
    low: float,
    high: float,
    judge: Judge = lambda _: None,
    steps: Steps = Steps(),
) -> WholePath:
    """`follow` up and down from the solution x at p; a closed path is followed once."""
    up = follow(equations, start(equations, x, p, 1.0), low, high, judge, steps)
    if up.stop is Stop.CLOSED:
        return WholePath(up.points, (up.ending, up.ending))
    down = follow(equations, start(equations, x, p, -1.0), low, high, judge, steps)
    return WholePath((*reversed(down.points[1:]), *up.points), (down.ending, up.ending))


def between(
    equations: Equations,
    here: Point,
    ahead: Point,
    share: float,
    near: tuple[float, Point] | None = None,
    tolerance: float = 1e-14,
) -> Point | None:
    """The point of the path in the plane at `share` of the chord from `here` to `ahead`, its
    tangent along the chord; None where Newton does not converge. `near`, the point at another
    share, makes it quicker."""
    step, rise = ahead.x - here.x, ahead.p - here.p
    plane = _joined(step / here.size, rise)
    known, at = near or (0.0, here)
    x, p = at.x + (share - known) * step, at.p + (share - known) * rise
    found = correct(equations, x, p, plane / _length(plane), here.size, tolerance)
    return None if found is None else found[0]


def _step(
    equations: Equations, before: Point | None, here: Point, h: float, steps: Steps
) -> tuple[Point | None, float]:
    """The next point, and the length to try after it."""
    while h >= steps.smallest:
        guess = _ahead(before, here, h)
        found = correct(
            equations, guess[:-1], float(guess[-1]), here.tangent, here.size, steps.tolerance
        )
        if found is not None:
            ahead, iterations = found
            angle = math.acos(min(1.0, float(ahead.tangent @ here.tangent)))
            jumped = ahead.side != here.side and h > steps.crossing
            if angle < 2 * steps.turn and not jumped:
                grow = min(steps.turn / max(angle, 1e-3), 3.0 / iterations, 2.0)
                return _measured(ahead), min(h * max(0.3, grow), steps.largest)
        h *= 0.5
    return None, h


def _ahead(before: Point | None, here: Point, h: float) -> Array:
    """x and p (n + 1,) a length h ahead, on the cubic that two points and their tangents give."""
    scale = _joined(np.full(len(here.x), here.size), 1.0)
    slope, place = here.tangent * scale, _joined(here.x, here.p)
    if before is None:
        return np.asarray(place + h * slope)
    chord = place - _joined(before.x, before.p)
    old = _joined(before.tangent[:-1] * before.size, before.tangent[-1])
    old /= _length(old / scale)
    turn = _length((slope - old) / scale)
    # an arc over its chord, to second order
    length = _length(chord / scale) * (1.0 + turn**2 / 24.0)
    u = h / length
    bend = (2.0 * slope + old) * length - 3.0 * chord
    twist = (slope + old) * length - 2.0 * chord
    return np.asarray(place + u * length * slope + u**2 * bend + u**3 * twist)


def _measured(point: Point) -> Point:
    """The point with `size` that of its own x."""
    size = _length(point.x) or point.size
    along = _joined(point.tangent[:-1] * (point.size / size), point.tangent[-1])
    return replace(point, tangent=along / _length(along), size=size)


def _passed(home: Point, here: Point, ahead: Point) -> bool:
    """Does the step from `here` to `ahead` pass `home`, in its direction?"""
    behind = _joined((home.x - here.x) / home.size, home.p - here.p)
    step = _joined((ahead.x - here.x) / home.size, ahead.p - here.p)
    length = _length(step)
    share = float(behind @ step) / length**2
    if not 0.0 < share <= 1.0 or float(step @ home.tangent) < 0.5 * length:
        return False
    return _length(behind - share * step) < 0.2 * length


def _at_bound(
    equations: Equations, here: Point, ahead: Point, bound: float, steps: Steps
) -> Point | None:
    share = (bound - here.p) / (ahead.p - here.p)
    x = solve(equations, here.x + share * (ahead.x - here.x), bound, steps.tolerance)
    if x is None:
        return None
    return _measured(_located(equations, x, bound, here.size, here.tangent))


def _located(equations: Equations, x: Array, p: float, size: float, plane: Array) -> Point:
    """The point of a solution, its tangent in the half space of `plane`."""
    found = _newton(equations, x, p, plane, size)
    return Point(x, p, plane, size) if found is None else Point(x, p, found[1], size, found[2])


def _newton(
    equations: Equations, x: Array, p: float, plane: Array, size: float
) -> tuple[Array, Array, float] | None:
    """Newton's move (x over size, p) across `plane`, the unit tangent, and the sign of the
    determinant; None where the slope is singular or not finite."""
    from scipy.linalg.lapack import dgesv

    residual, jacobian, slope = _quiet(equations, x, p)
    n = len(slope)
    matrix, right = np.empty((n + 1, n + 1), order='F'), np.zeros((n + 1, 2), order='F')
    np.multiply(jacobian, size, out=matrix[:n, :n])
    matrix[:n, n], matrix[n] = slope, plane
    right[:n, 0], right[n, 1] = residual, 1.0
    if not math.isfinite(matrix.sum() + residual.sum()):
        return None
    factors, swaps, found, failed = dgesv(matrix, right, overwrite_a=True, overwrite_b=True)
    if failed:
        return None
    odd = np.count_nonzero(swaps != np.arange(n + 1)) + np.count_nonzero(factors.diagonal() < 0)
    along = found[:, 1]
    return found[:, 0], along / _length(along), -1.0 if odd % 2 else 1.0


def _solved(matrix: Array, right: Array) -> Array | None:
    if not (np.isfinite(matrix).all() and np.isfinite(right).all()):
        return None
    try:
        return np.asarray(np.linalg.solve(matrix, right))
    except np.linalg.LinAlgError:
        return None


def _quiet(equations: Equations, x: Array, p: float) -> tuple[Array, Array, Array]:
    with np.errstate(all='ignore'):
        return equations.linearised(x, p)


def _joined(x: Array, p: float) -> Array:
    """(n + 1,): a part in x and one in p."""
    whole = np.empty(len(x) + 1)
    whole[:-1], whole[-1] = x, p
    return whole


def _length(vector: Array) -> float:
    return math.sqrt(vector @ vector)
