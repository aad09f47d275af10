"""Does a run repeat itself? What the stroboscope's kernel asks once a period.

`past` (6, BACK, LANES) holds the last periods of all lanes, newest at `slot`: w, w', and the sums
of strobe_kernel.advance.
"""

from __future__ import annotations

from typing import Any

import numpy as np

LANES = 64
"""Runs that move together: their loops turn into vector instructions."""

BACK = 33
"""Periods that are remembered: twice the longest cycle looked for, and one."""

DISTINCT = 100.0
"""Tolerances by which two points of a cycle differ at least."""

ROUNDING = 1e-12
"""A return as close as this is one, however slow the motion settles."""


def look_back(past: Any, slot: int, longest: int, tolerance: float, found: Any) -> None:
    """`found` (LANES,): after how few periods, up to `longest`, each lane has come back, or 0."""
    for lane in range(LANES):
        found[lane] = 0.0
    for period in range(1, longest + 1):
        before = (slot - period) % BACK
        for lane in range(LANES):
            near = abs(past[0, slot, lane] - past[0, before, lane]) <= tolerance
            near &= abs(past[1, slot, lane] - past[1, before, lane]) <= tolerance
            found[lane] = period if near and found[lane] == 0.0 else found[lane]


def apart(past: Any, lane: int, one: int, other: int, scale: float) -> float:
    """Distance of two remembered points; `scale` is what makes w' comparable to w."""
    one, other = one % BACK, other % BACK
    across = abs(past[0, one, lane] - past[0, other, lane])
    along = scale * abs(past[1, one, lane] - past[1, other, lane])
    return float(max(across, along))


def returned(
    past: Any, slot: int, lane: int, period: int, age: int, scale: float, tolerance: float
) -> float:
    """How far a motion that comes back after `period` may still wander: what is left of it.

    Later returns are taken to shrink as the last ones did. Infinite where they do not, and where
    the run nearly comes back after a part of the period: it may do so once its transient is gone.
    """
    lag = period * max(1, 8 // period)
    if age <= lag + period:
        return np.inf
    for part in range(1, period):
        if period % part == 0 and apart(past, lane, slot, slot - part, scale) <= (
            DISTINCT * tolerance
        ):
            return np.inf
    near = apart(past, lane, slot, slot - period, scale)
    if near <= ROUNDING:
        return 0.0
    far = apart(past, lane, slot - lag, slot - lag - period, scale)
    return near * (lag // period) / (1.0 - near / far) if near < far else np.inf


def finish(
    past: Any, slot: int, lane: int, cycle: int, age: int, periods: int, points: Any, figures: Any
) -> None:
    """Fill the `points` (2, keep) that the cycle saved, and the six `figures` of a run."""
    keep = points.shape[1]
    for late in range(age + 1, periods + 1):
        place = late - (periods - keep) - 1
        if place >= 0:
            back = (age - late) % cycle
            points[0, place] = past[0, (slot - back) % BACK, lane]
            points[1, place] = past[1, (slot - back) % BACK, lane]
    end = (slot - (age - periods) % cycle) % BACK if cycle else slot
    figures[0], figures[1] = past[0, end, lane], past[1, end, lane]
    span = cycle if cycle else min(age, BACK - 1)
    figures[2] = figures[3] = 0.0
    figures[4], figures[5] = np.inf, -np.inf
    for back in range(span):
        k = (slot - back) % BACK
        figures[2] += past[2, k, lane] / span
        figures[3] += past[3, k, lane] / span
        figures[4] = min(figures[4], past[4, k, lane])
        figures[5] = max(figures[5], past[5, k, lane])
