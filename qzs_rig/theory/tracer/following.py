"""Pseudo-arc-length continuation of one oscillator's periodic motion, written once for the
interpreter and numba.

Seydel, Practical Bifurcation and Stability Analysis (2010), sections 4.3 to 4.6. The predictor is
the cubic through the last four points over their arc length; what the corrector adds to it sets
the step. Lengths are relative: a frequency over itself, coefficients over the amplitude.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from qzs_rig.theory.tracer.balancing import BALANCED, LEFT, aliasing, hold
from qzs_rig.theory.tracer.elimination import orientation, substitute

AT_LOW, AT_HIGH, CLOSED, UNSTARTED, OFF, STUCK, FULL = range(7)
"""Why `follow` ends."""

ORDER = 4
"""Points that the predictor goes through."""
COARSE, FINE = 3e-4, 1e-8
"""What every other sample may change in the balance before there are twice as many, and how little
before there are half. All of them change about the square of it."""


class Walk(NamedTuple):
    """From `begin` within [low, high] towards higher or lower Ω (`sense` 1 or -1), in steps of
    `step` at most, the predictor missing by about `miss`.

    `settling`: the start is found by waiting, not by Newton alone. `finest`: how often the number
    of samples may be doubled.
    """

    begin: float
    low: float
    high: float
    sense: float
    step: float
    miss: float
    settling: bool
    finest: int


def follow(
    sample: Any,
    settle: Any,
    correct: Any,
    motion: Any,
    scratch: Any,
    walk: Any,
    y: Any,
    path: Any,
    s: Any,
) -> tuple[int, int]:
    """From the motion near y at walk.begin along its branch, through folds, out of the band.

    Fills path (., 2H + 2) and its arc length s. Returns the number of points and why it ended;
    where that is at an edge of the band, the last point lies exactly on it.
    """
    level = begin(sample, settle, correct, motion, scratch, walk, y, path[0])
    if level < 0:
        return 0, UNSTARTED
    keep(path[0], y)
    s[0], h, count, edge, sign, first, off = 0.0, 0.1 * walk.step, 1, 0.0, 0.0, 0, False
    while count < len(path):
        last = path[count - 1]
        weigh(last, scratch.weight)
        if first == count - 1:
            depart(sample, correct, motion, scratch, level, last, sign, walk.sense, h, y)
        else:
            near = max(first, count - ORDER)
            extrapolate(s[near:count], path[near:count], s[count - 1] + h, y, scratch)
        for c in range(len(y)):
            scratch.guess[c] = y[c]
            scratch.normal[c] = scratch.weight[c] * scratch.along[c]
        if edge > 0.0:
            hold(scratch, y, edge)
        ended = correct(sample, motion, scratch, level, False, y)
        miss = distance(y, scratch.guess, scratch.weight)
        side = orientation(scratch.rows, scratch.order)
        # where `side` changes is another branch, or a branch point; only that stays when near
        strayed = sign not in (side, 0.0) and h > 0.02 * walk.step and edge == 0.0
        if ended != BALANCED or miss > min(8.0 * walk.miss, 0.3 * h) or strayed:
            h, edge, off = 0.5 * h, 0.0, off or ended == LEFT
            if h < 1e-5 * walk.step:
                return count, OFF if off else STUCK
            if count > 1 and h < 0.1 * (s[count - 1] - s[count - 2]):
                # a bend so sharp that the points before it mislead
                first = count - 1
            continue
        mixed = aliasing(motion, scratch, level, y)
        if mixed > COARSE and level < walk.finest:
            level += 1
            continue
        if mixed < FINE and level > 0:
            level -= 1
        length = distance(y, last, scratch.weight)
        keep(path[count], y)
        s[count] = s[count - 1] + length
        if edge > 0.0:
            return count + 1, AT_LOW if edge == walk.low else AT_HIGH
        edge = crossed(walk, y[len(y) - 1])
        if edge > 0.0:
            # take the step again, to the edge that it has crossed
            h = length * (edge - last[len(y) - 1]) / (y[len(y) - 1] - last[len(y) - 1])
            continue
        sign, off = side, False
        count += 1
        if count > ORDER and is_home(walk, scratch, s, path, count, y):
            keep(path[count - 1], path[0])
            return count, CLOSED
        growth = 0.9 * (walk.miss / (miss + 1e-300)) ** (1.0 / max(2, min(count - first, ORDER)))
        h = min(walk.step, length * min(2.0, growth))
    return count, FULL


def begin(
    sample: Any,
    settle: Any,
    correct: Any,
    motion: Any,
    scratch: Any,
    walk: Any,
    y: Any,
    start: Any,
) -> int:
    """Turn the guess y into a motion at walk.begin; its level of sampling, -1 where none is near.

    Newton from the guess, else from what the guess, kept in `start`, becomes with time.
    """
    y[len(y) - 1] = walk.begin
    for attempt in range(12):
        if attempt > 0 or walk.settling:
            settle(sample, motion, scratch, y)
        keep(start, y)
        for level in range(walk.finest + 1):
            hold(scratch, y, walk.begin)
            if correct(sample, motion, scratch, level, False, y) != BALANCED:
                break
            if level == walk.finest or aliasing(motion, scratch, level, y) <= COARSE:
                return level
        keep(y, start)
    return -1


def depart(
    sample: Any,
    correct: Any,
    motion: Any,
    scratch: Any,
    level: int,
    last: Any,
    sign: float,
    sense: float,
    h: float,
    y: Any,
) -> None:
    """Put y a length h along the tangent at `last`: in the direction in which the determinant of
    the slope with the tangent below it has this `sign`, or with 0 in which `sense` points."""
    along, n = scratch.along, len(y) - 1
    keep(y, last)
    hold(scratch, y, last[n])
    correct(sample, motion, scratch, level, True, y)
    for c in range(n):
        along[c] = 0.0
    along[n] = sense if sign == 0.0 else sign * orientation(scratch.rows, scratch.order)
    substitute(scratch.rows, scratch.order, along)
    for c in range(n + 1):
        y[c] = last[c] + along[c]
    scale = h / distance(y, last, scratch.weight)
    for c in range(n + 1):
        y[c] = last[c] + scale * along[c]


def crossed(walk: Any, omega: float) -> float:
    """The edge of the band beyond which `omega` lies, 0 within."""
    if omega < walk.low:
        return float(walk.low)
    if omega > walk.high:
        return float(walk.high)
    return 0.0


def is_home(walk: Any, scratch: Any, s: Any, path: Any, count: int, y: Any) -> bool:
    """Did the last step pass the first point? Overwrites y."""
    home, here, last, weight = path[0], path[count - 1], path[count - 2], scratch.weight
    along, length = 0.0, s[count - 1] - s[count - 2]
    for c in range(len(y)):
        along += weight[c] * (home[c] - last[c]) * (here[c] - last[c])
    share = along / (length * length)
    if not 0.0 < share <= 1.0 or distance(home, last, weight) > 1.2 * length:
        return False
    at = s[count - 2] + share * length
    near = count - ORDER
    extrapolate(s[near:count], path[near:count], at, y, scratch)
    return bool(distance(home, y, weight) < 4.0 * walk.miss)


def extrapolate(s: Any, path: Any, at: float, y: Any, scratch: Any) -> None:
    """Fill y and its slope `along` with the polynomial through `path` over s at `at`."""
    along = scratch.along
    for c in range(len(y)):
        y[c] = along[c] = 0.0
    for i in range(len(s)):
        weight, rise = 1.0, 0.0
        for j in range(len(s)):
            if j != i:
                gap = s[i] - s[j]
                rise = (rise * (at - s[j]) + weight) / gap
                weight *= (at - s[j]) / gap
        point = path[i]
        for c in range(len(y)):
            y[c] += weight * point[c]
            along[c] += rise * point[c]


def weigh(y: Any, weight: Any) -> None:
    """Fill the weights of a length at y: 1/Ω² and, for coefficients, 1/amplitude²."""
    n, square = len(y) - 1, 0.0
    for c in range(1, n):
        square += y[c] * y[c]
    for c in range(n):
        weight[c] = 1.0 / square
    weight[n] = 1.0 / (y[n] * y[n])


def distance(a: Any, b: Any, weight: Any) -> float:
    """Weighted length of a - b."""
    square = 0.0
    for c in range(len(a)):
        square += weight[c] * (a[c] - b[c]) * (a[c] - b[c])
    return math.sqrt(square)


def keep(point: Any, y: Any) -> None:
    """Write y down as a point."""
    for c in range(len(y)):
        point[c] = y[c]
