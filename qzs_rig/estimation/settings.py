"""Everything the sine estimators can be told; frozen, validated, one unit a field."""

from __future__ import annotations

from dataclasses import dataclass, fields

from qzs_rig.errors import InputError
from qzs_rig.units import TRANSLATIONS

BOUNDS = {
    'periods': (2.0, 64.0),
    'hop_periods': (0.1, 64.0),
    'harmonics': (1, 20),
    'frequency_min': (0.01, 1e4),
    'frequency_max': (0.01, 1e5),
    'chirp_max': (0.0, 100.0),
    'floor_acceleration': (0.0, 1e3),
    'floor_rate': (0.0, 1e3),
    'residual_max': (1e-6, 1.0),
    'settle_tolerance': (1e-9, 1.0),
    'settle_periods': (1.0, 1e4),
    'plateau_tolerance': (1e-6, 0.1),
}
"""Inclusive limits of each field of TrackedSineSettings."""


@dataclass(frozen=True)
class TrackedSineSettings:
    """How a sine is followed. Raises InputError for a value outside BOUNDS.

    periods             length of the analysis window, periods of the base motion
    hop_periods         distance between window centres, periods
    harmonics           highest harmonic fitted, 1 is the fundamental; those above 0.8 of the
                        Nyquist frequency are left out
    frequency_min       Hz, lowest tone that is looked for
    frequency_max       Hz, highest tone that is looked for (never above 0.8 Nyquist)
    chirp_max           Hz/s, fastest sweep, up or down, that is looked for
    floor_acceleration  m/s², a translation whose base amplitude is below is not excited
    floor_rate          rad/s, a rotation whose base amplitude is below is not excited
    residual_max        1, tone-like misfit of the base over its fundamental (both rms) above
                        which a window is dropped; white noise is not counted as misfit
    settle_tolerance    1, |T - mean T| / |mean T| that a settled plateau may show
    settle_periods      periods over which the tolerance must hold at the end of a plateau
    plateau_tolerance   1, relative change of frequency that still is one plateau
    """

    periods: float = 4.0
    hop_periods: float = 1.0
    harmonics: int = 5
    frequency_min: float = 0.3
    frequency_max: float = 50.0
    chirp_max: float = 0.5
    floor_acceleration: float = 0.01
    floor_rate: float = 0.001
    residual_max: float = 0.05
    settle_tolerance: float = 0.002
    settle_periods: float = 8.0
    plateau_tolerance: float = 0.001

    def __post_init__(self) -> None:
        for item in fields(self):
            value, (low, high) = getattr(self, item.name), BOUNDS[item.name]
            if not low <= value <= high:
                raise InputError(
                    f'estimation {item.name} = {value} is outside {low:g} to {high:g}; '
                    'choose a value inside'
                )
        if self.frequency_min >= self.frequency_max:
            raise InputError(
                f'estimation frequency_min = {self.frequency_min} Hz is not below '
                f'frequency_max = {self.frequency_max} Hz; widen the band'
            )

    def floor(self, dof: str) -> float:
        """Base amplitude below which `dof` is not excited, m/s² or rad/s."""
        return self.floor_acceleration if dof in TRANSLATIONS else self.floor_rate
