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

import numpy as np
from numpy.typing import NDArray

from qzs_rig.estimation.estimate import Curve
from qzs_rig.estimation.tracker import Point
from qzs_rig.samples import Array

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
