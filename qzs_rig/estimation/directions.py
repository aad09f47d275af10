"""Which way the frequency went: cutting a track into upward and downward runs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from qzs_rig.samples import Array

DWELL = 0.01
"""A track whose frequency spans less than this share of itself did not sweep."""
TURN = 0.05
"""Share of the whole span that the frequency must come back before the sweep has turned."""


class Run(NamedTuple):
    """Points [first, last) went one way: 'forward' up, 'reverse' down, 'none' nowhere."""

    first: int
    last: int
    direction: str


def sweep_runs(frequency_hz: Array) -> list[Run]:
    """The runs of a tracked sweep (n,), without the holds at their ends; one run of direction
    'none' if the frequency stayed. Robust to scattered points: a turn counts from TURN of the span
    on."""
    smooth = _median_of_five(frequency_hz)
    scatter = _scatter(frequency_hz)
    span = float(np.ptp(smooth)) if len(smooth) else 0.0
    if span < max(DWELL * float(np.median(smooth)) if len(smooth) else 0.0, 10.0 * scatter):
        return [Run(0, len(smooth), 'none')] if len(smooth) else []
    runs = monotone_runs(smooth, max(TURN * span, 5.0 * scatter))
    return [_without_holds(smooth, run, scatter) for run in runs]


def monotone_runs(frequency_hz: Array, hysteresis: float) -> list[Run]:
    """Cut (n,) at each extreme that is followed by a return of more than `hysteresis` Hz; the
    extreme belongs to the run it ends. A single point is one run of direction 'none'."""
    values = frequency_hz.tolist()
    if len(values) < 2:
        return [Run(0, len(values), 'none')] if values else []
    turns = _turns(values, hysteresis)
    edges = [0, *(turn + 1 for turn in turns), len(values)]
    ends = [0, *turns, len(values) - 1]
    return [
        Run(
            edges[i],
            edges[i + 1],
            'forward' if values[ends[i + 1]] > values[ends[i]] else 'reverse',
        )
        for i in range(len(edges) - 1)
        if edges[i + 1] > edges[i]
    ]


def _turns(values: list[float], hysteresis: float) -> list[int]:
    """Indices of the extremes at which the series turned, alternating maxima and minima."""
    turns: list[int] = []
    low = high = 0
    rising: bool | None = None
    for i, value in enumerate(values):
        high = i if value > values[high] else high
        low = i if value < values[low] else low
        if rising is not False and values[high] - value > hysteresis:
            turns += [] if rising is None else [high]
            rising, low = False, i
        elif rising is not True and value - values[low] > hysteresis:
            turns += [] if rising is None else [low]
            rising, high = True, i
    return turns


def _without_holds(smooth: Array, run: Run, scatter: float) -> Run:
    """Keep one point of a hold at either end: while the base waits, the top's start-up dies."""
    part = smooth[run.first : run.last]
    steps = np.abs(np.diff(part))
    moving = steps[steps > max(2.0 * scatter, 1e-6 * float(part[0]))]
    if not len(moving):
        return run
    hold = max(3.0 * scatter, 0.5 * float(np.median(moving)))
    away_from_start = np.flatnonzero(np.abs(part - part[0]) > hold)
    away_from_end = np.flatnonzero(np.abs(part - part[-1]) > hold)
    first = max(int(away_from_start[0]) - 1, 0) if len(away_from_start) else 0
    last = min(int(away_from_end[-1]) + 2, len(part)) if len(away_from_end) else len(part)
    return Run(run.first + first, run.first + last, run.direction)


def _median_of_five(values: Array) -> Array:
    if len(values) < 5:
        return values
    inner = np.median(np.lib.stride_tricks.sliding_window_view(values, 5), axis=1)
    return np.concatenate([values[:2], inner, values[-2:]])


def _scatter(values: Array) -> float:
    """Standard deviation of the noise on a smooth series: second differences have 6 times its
    variance."""
    if len(values) < 5:
        return 0.0
    return 1.4826 * float(np.median(np.abs(np.diff(values, 2)))) / 6**0.5
