"""The tracked points of one degree of freedom as columns, in order of time, and how well they are
known.

Noise of the fits, and T that does not rest, are relative standard uncertainties of |T|, independent
of each other, so their squares add (JCGM 100:2008, 5.1). What they do not know: a sensor's
calibration, the other axes in the signal, and the lag of a sweep that outruns the platform's
memory.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from qzs_rig.estimation.estimate import Curve
from qzs_rig.estimation.tracker import Point
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


FIT = 2.0
"""A fundamental fitted with a moving envelope under the weight (1 - u²)² scatters twice as much
as one of constant amplitude in the same white noise, which scatters by residual / sqrt(samples)."""


@dataclass(frozen=True)
class Track:
    """Columns (n,): centre times (s), base frequency (Hz), T = top / base, the top's distortion,
    base amplitude (m/s² or rad/s), relative uncertainty of T from noise."""

    time_s: Array
    frequency_hz: Array
    transmissibility: NDArray[np.complex128]
    thd: Array
    amplitude: Array
    noise: Array

    def __len__(self) -> int:
        return int(self.time_s.shape[0])

    def slice(self, first: int, last: int) -> Track:
        """Points `first` to `last` (excluded)."""
        part = slice(first, last)
        return Track(
            self.time_s[part],
            self.frequency_hz[part],
            self.transmissibility[part],
            self.thd[part],
            self.amplitude[part],
            self.noise[part],
        )

    def curve(self, dof: str, direction: str, estimator: str, unrest: Array) -> Curve:
        """The track as a Curve of fundamentals; `unrest` (n,) is the relative uncertainty of T
        because it did not stand still."""
        magnitude = np.abs(self.transmissibility)
        phase = np.degrees(np.angle(self.transmissibility))
        return Curve(
            dof=dof,
            direction=direction,
            estimator=estimator,
            quantity='fundamental',
            frequency_hz=self.frequency_hz,
            magnitude=magnitude,
            phase_deg=np.where(phase == -180.0, 180.0, phase),
            thd=self.thd,
            uncertainty=magnitude * np.hypot(self.noise, unrest),
        )


def track_of(points: Sequence[Point]) -> Track:
    """The columns of `points`."""
    real = np.array(
        [(p.time_s, p.frequency_hz, p.thd, p.base_amplitude, noise(p)) for p in points],
        dtype=np.float64,
    ).reshape(-1, 5)
    value = np.array([p.transmissibility for p in points], dtype=np.complex128)
    return Track(real[:, 0], real[:, 1], value, *real[:, 2:].T)


def noise(point: Point) -> float:
    """From what the fits of base and top left over, as if it were white."""
    return FIT * math.hypot(point.base_residual, point.top_residual) / math.sqrt(point.samples)


def unrest(time_s: Array, frequency_hz: Array, magnitude: Array, periods: float) -> Array:
    """From the change of T (n,) within half a window of `periods`: the point stands for any moment
    of it alike (a rectangular distribution, JCGM 100:2008, 4.3.7). 0 for a single point."""
    if len(time_s) < 2:
        return np.zeros(len(time_s))
    with np.errstate(divide='ignore', invalid='ignore'):
        rate = np.gradient(np.log(magnitude), time_s)
    return np.asarray(np.abs(rate) * 0.5 * periods / frequency_hz / math.sqrt(3.0))
