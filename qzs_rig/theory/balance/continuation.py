"""Pseudo-arc-length continuation of the solutions of any equations with one parameter.

Krack and Gross, Harmonic Balance for Nonlinear Vibration Problems (2019), section 4.4; Seydel,
Practical Bifurcation and Stability Analysis (2010), sections 4.3 to 4.6.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from qzs_rig.samples import Array
from qzs_rig.theory.balance.newton import (
    Equations,
    Point,
    correct,
    joined,
    length_of,
    located,
    solve,
    start,
)


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


StopCheck = Callable[[Point, Point], Ending | None]
"""Looks at a step from the last point to the new one: why the path ends with it, or None."""


def follow(
    equations: Equations,
    first: Point,
    low: float,
    high: float,
    stop_check: StopCheck = lambda *_: None,
    steps: Steps = Steps(),
    origin: Point | None = None,
) -> Path:
    """From `first` along its tangent until p leaves [low, high] (the last point lies on the bound),
    the path closes at `origin`, `stop_check` ends it, or no step succeeds."""
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
        ending = stop_check(here, ahead)
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
    stop_check: StopCheck = lambda *_: None,
    steps: Steps = Steps(),
) -> WholePath:
    """`follow` up and down from the solution x at p; a closed path is followed once."""
    up = follow(equations, start(equations, x, p, 1.0), low, high, stop_check, steps)
    if up.stop is Stop.CLOSED:
        return WholePath(up.points, (up.ending, up.ending))
    down = follow(equations, start(equations, x, p, -1.0), low, high, stop_check, steps)
    return WholePath((*reversed(down.points[1:]), *up.points), (down.ending, up.ending))


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
    scale = joined(np.full(len(here.x), here.size), 1.0)
    slope, place = here.tangent * scale, joined(here.x, here.p)
    if before is None:
        return np.asarray(place + h * slope)
    chord = place - joined(before.x, before.p)
    old = joined(before.tangent[:-1] * before.size, before.tangent[-1])
    old /= length_of(old / scale)
    turn = length_of((slope - old) / scale)
    # an arc over its chord, to second order
    length = length_of(chord / scale) * (1.0 + turn**2 / 24.0)
    u = h / length
    bend = (2.0 * slope + old) * length - 3.0 * chord
    twist = (slope + old) * length - 2.0 * chord
    return np.asarray(place + u * length * slope + u**2 * bend + u**3 * twist)


def _measured(point: Point) -> Point:
    """The point with `size` that of its own x."""
    size = length_of(point.x) or point.size
    along = joined(point.tangent[:-1] * (point.size / size), point.tangent[-1])
    return replace(point, tangent=along / length_of(along), size=size)


def _passed(home: Point, here: Point, ahead: Point) -> bool:
    """Does the step from `here` to `ahead` pass `home`, in its direction?"""
    behind = joined((home.x - here.x) / home.size, home.p - here.p)
    step = joined((ahead.x - here.x) / home.size, ahead.p - here.p)
    length = length_of(step)
    share = float(behind @ step) / length**2
    if not 0.0 < share <= 1.0 or float(step @ home.tangent) < 0.5 * length:
        return False
    return length_of(behind - share * step) < 0.2 * length


def _at_bound(
    equations: Equations, here: Point, ahead: Point, bound: float, steps: Steps
) -> Point | None:
    share = (bound - here.p) / (ahead.p - here.p)
    x = solve(equations, here.x + share * (ahead.x - here.x), bound, steps.tolerance)
    if x is None:
        return None
    return _measured(located(equations, x, bound, here.size, here.tangent))
