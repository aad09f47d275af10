"""Reading onset, peak and jumps off a transmissibility curve.

A jump is told from a steep linear resonance by a bound that no linear platform passes: without
damping T = 1/|1 - x²|, x = f/f_n, gives |d ln(1 + 1/T) / d ln f| <= 2 everywhere, with equality
above the resonance, and damping only flattens it. A jump moves T by a factor while f stands
almost still, within the few periods of one analysis window.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from qzs_rig.estimation.estimate import Curve, Event
from qzs_rig.samples import Array

LINEAR_SLOPE = 2.0
MARGIN = 2.0
"""Times the linear bound from which a step is abrupt; leaves room for the ringing of a sweep at
the ISO 7626-2 rate limit and for noise."""
SIZE = 1.5
"""Least ratio of the levels before and after a jump."""
LEVEL = 8
"""Least number of tracked points whose median is the level before or after."""
PROMINENCE = 1.05
"""Least ratio of a peak to both ends of its curve."""
RINGING = 40
"""Points after a jump in which the free vibration it excited still beats with the sine."""


class Jump(NamedTuple):
    """T went from level `before` to `after` between the points `first` and `last`."""

    first: int
    last: int
    before: float
    after: float
    frequency_hz: float

    @property
    def ratio(self) -> float:
        """Of the higher level to the lower one."""
        return max(self.before, self.after) / min(self.before, self.after)


def find_events(curve: Curve, settled: bool = False) -> tuple[Event, ...]:
    """Onset, peak and jumps of `curve`, as far as it shows them; none for a dwell. `settled`:
    each point stands for itself, as of a stepped sine, and carries no free vibration.

    jump_down, jump_up  T fell or rose abruptly in the order of time; magnitude is the level
                        before, the resolution the frequency that passed meanwhile
    peak                largest T inside the curve, on a parabola through its neighbours
    onset               highest frequency at which T falls through 1 with increasing frequency
    """
    if curve.direction == 'none' or len(curve.frequency_hz) < 3:
        return ()
    jumps = find_jumps(curve, settled)
    found = [_onset(curve, jumps), _peak(curve, jumps)]
    return (*(event for event in found if event), *(_jump_event(curve, jump) for jump in jumps))


def find_jumps(curve: Curve, settled: bool = False) -> list[Jump]:
    """The jumps of `curve`, in order of time."""
    gain = np.log1p(1.0 / np.maximum(curve.magnitude, 1e-12))
    moved = np.abs(np.diff(np.log(curve.frequency_hz)))
    change = np.diff(gain)
    bound = MARGIN * LINEAR_SLOPE * moved + 1e-9
    groups = [group for sign in (1.0, -1.0) for group in _groups(sign * change > bound)]
    width, ringing = (1, 0) if settled else (LEVEL, RINGING)
    jumps = [jump for group in groups if (jump := _jump(curve, *group, width)) is not None]
    kept: list[Jump] = []
    for jump in sorted(jumps):
        if not kept or jump.first > kept[-1].last + ringing:
            kept.append(jump)
    return kept


def _groups(abrupt: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last point of each stretch of abrupt steps; one calm step does not part it."""
    steps = np.flatnonzero(abrupt)
    if not len(steps):
        return []
    parts = np.split(steps, np.flatnonzero(np.diff(steps) > 2) + 1)
    return [(int(part[0]), int(part[-1]) + 1) for part in parts]


def _jump(curve: Curve, first: int, last: int, width: int) -> Jump | None:
    """The jump over [first, last] if its levels, taken over `width` points, differ by more than a
    linear platform could bring about from end to end, and persist while the frequency stands."""
    if first < width - 1 or last + width > len(curve.magnitude):
        return None
    jump = _levels(curve, first, last, width)
    change = abs(math.log1p(1.0 / jump.after) - math.log1p(1.0 / jump.before))
    if jump.ratio < SIZE or change < _linear_change(curve, first, last, width):
        return None
    for wider in (2 * width, 4 * width, 8 * width) if width > 1 else ():
        still = 4.0 * _linear_change(curve, first, last, wider) < change
        if still and _levels(curve, first, last, wider).ratio < SIZE:
            return None
    return jump


def _levels(curve: Curve, first: int, last: int, width: int) -> Jump:
    level = curve.magnitude
    before = float(np.median(level[max(first - width + 1, 0) : first + 1]))
    after = float(np.median(level[last : last + width]))
    return Jump(first, last, before, after, _crossing(curve, first, last, (before + after) / 2))


def _linear_change(curve: Curve, first: int, last: int, width: int) -> float:
    """MARGIN times what ln(1 + 1/T) of a linear platform could change between the middles of the
    two levels."""
    low = max(first - width // 2, 0)
    high = min(last + width // 2, len(curve.frequency_hz) - 1)
    moved = abs(math.log(curve.frequency_hz[high] / curve.frequency_hz[low]))
    return MARGIN * LINEAR_SLOPE * moved


def _crossing(curve: Curve, first: int, last: int, level: float) -> float:
    """Frequency at which the magnitude passes `level` between two points, Hz: halfway through the
    window that straddles a jump."""
    magnitude, frequency = curve.magnitude, curve.frequency_hz
    over = magnitude[first : last + 1] > level
    turns = np.flatnonzero(over[1:] != over[:-1])
    at = first + int(turns[0]) if len(turns) else first
    rise = magnitude[at + 1] - magnitude[at]
    share = float(np.clip((level - magnitude[at]) / rise, 0.0, 1.0)) if rise else 0.5
    return float(frequency[at] + share * (frequency[at + 1] - frequency[at]))


def _jump_event(curve: Curve, jump: Jump) -> Event:
    kind = 'jump_down' if jump.after < jump.before else 'jump_up'
    width = abs(float(curve.frequency_hz[jump.last] - curve.frequency_hz[jump.first]))
    return Event(curve.dof, curve.direction, kind, jump.frequency_hz, jump.before, width)


def _onset(curve: Curve, jumps: list[Jump]) -> Event | None:
    through = _jump_through_one(jumps)
    rising = curve.direction == 'forward'
    level = curve.magnitude if rising else curve.magnitude[::-1]
    frequency = curve.frequency_hz if rising else curve.frequency_hz[::-1]
    falls = np.flatnonzero((level[:-1] >= 1.0) & (level[1:] < 1.0))
    if not len(falls):
        return None
    at = int(falls[-1])
    place = at if rising else len(level) - 2 - at
    if through is not None and through.first - 1 <= place <= through.last + RINGING:
        width = abs(float(curve.frequency_hz[through.last] - curve.frequency_hz[through.first]))
        return Event(curve.dof, curve.direction, 'onset', through.frequency_hz, 1.0, width)
    share = float(np.log(level[at]) / np.log(level[at] / level[at + 1]))
    width = abs(float(frequency[at + 1] - frequency[at]))
    crossed = float(frequency[at] + share * (frequency[at + 1] - frequency[at]))
    return Event(curve.dof, curve.direction, 'onset', crossed, 1.0, width)


def _jump_through_one(jumps: list[Jump]) -> Jump | None:
    through = [j for j in jumps if min(j.before, j.after) < 1.0 <= max(j.before, j.after)]
    return max(through, key=lambda jump: jump.frequency_hz) if through else None


def _peak(curve: Curve, jumps: list[Jump]) -> Event | None:
    """None if the largest T hardly exceeds an end of the curve: the true one may lie beyond."""
    level, frequency = curve.magnitude, curve.frequency_hz
    at = int(np.argmax(level))
    if level[at] < PROMINENCE * max(level[0], level[-1]):
        return None
    width = float(np.max(np.abs(np.diff(frequency[at - 1 : at + 2]))))
    top, height = float(frequency[at]), float(level[at])
    if not any(jump.first <= at <= jump.last for jump in jumps):
        top, height = _vertex(frequency[at - 1 : at + 2], np.log(level[at - 1 : at + 2]))
    return Event(curve.dof, curve.direction, 'peak', top, height, width)


def _vertex(frequency: Array, log_level: Array) -> tuple[float, float]:
    """Frequency and T at the top of the parabola through three points; the middle one where noise
    has scattered the frequencies."""
    (a, b, c), (low, mid, high) = frequency.tolist(), log_level.tolist()
    if not abs(b - a) < 3.0 * abs(c - b) < 9.0 * abs(b - a) or (b - a) * (c - b) < 0.0:
        return b, math.exp(mid)
    rise, fall = (mid - low) / (b - a), (high - mid) / (c - b)
    bend = (fall - rise) / (c - a)
    slope = rise + bend * (b - a)
    step = -slope / (2.0 * bend) if bend else 0.0
    return b + step, math.exp(mid + slope * step + bend * step**2)
