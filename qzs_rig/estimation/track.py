"""The tracked points of one degree of freedom as columns, in order of time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from qzs_rig.estimation.estimate import Curve
from qzs_rig.estimation.tracker import Point
from qzs_rig.estimation.uncertainty import noise
from qzs_rig.samples import Array


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
