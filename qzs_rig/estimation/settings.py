"""What the sine estimators can be told: each setting declared once, frozen and validated."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any

from qzs_rig.errors import InputError
from qzs_rig.parameters import Parameter, RunSpec
from qzs_rig.units import TRANSLATIONS


def _setting(default: float, unit: str, description: str, low: float, high: float) -> Any:
    """A field with what its parameter needs; `low` and `high` are inclusive."""
    declared = {'unit': unit, 'description': description, 'bounds': (low, high)}
    return field(default=default, metadata=declared)


@dataclass(frozen=True)
class TrackedSineSettings:
    """How a sine is followed. Raises InputError for a value outside its bounds.

    Harmonics and tones above 0.8 of the Nyquist frequency are never looked for; a sweep is looked
    for both ways. What makes a window misfit is tone-like: white noise is not counted. A plateau is
    settled where |T - mean T| / |mean T| stays within `settle_tolerance`.
    """

    periods: float = _setting(
        4.0, '', 'length of the analysis window in periods of the base motion', 2.0, 64.0
    )
    hop_periods: float = _setting(1.0, '', 'distance between window centres in periods', 0.1, 64.0)
    harmonics: int = _setting(5, '', 'highest harmonic fitted; 1 is the fundamental', 1, 20)
    frequency_min: float = _setting(0.3, 'Hz', 'lowest tone that is looked for', 0.01, 1e4)
    frequency_max: float = _setting(50.0, 'Hz', 'highest tone that is looked for', 0.01, 1e5)
    chirp_max: float = _setting(0.5, 'Hz/s', 'fastest sweep that is looked for', 0.0, 100.0)
    floor_acceleration: float = _setting(
        0.01, 'm/s²', 'a translation whose base amplitude is below is not excited', 0.0, 1e3
    )
    floor_rate: float = _setting(
        0.001, 'rad/s', 'a rotation whose base amplitude is below is not excited', 0.0, 1e3
    )
    residual_max: float = _setting(
        0.05, '', 'misfit of the base, rms over its fundamental, that drops a window', 1e-6, 1.0
    )
    settle_tolerance: float = _setting(
        0.002, '', 'relative change of transmissibility that counts as settled', 1e-9, 1.0
    )
    settle_periods: float = _setting(
        8.0, '', 'periods at the end of a plateau over which that must hold', 1.0, 1e4
    )
    plateau_tolerance: float = _setting(
        0.001, '', 'relative change of frequency that still is one plateau', 1e-6, 0.1
    )

    def __post_init__(self) -> None:
        for item in fields(self):
            value, (low, high) = getattr(self, item.name), item.metadata['bounds']
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

    @classmethod
    def from_spec(cls, spec: RunSpec) -> TrackedSineSettings:
        """The settings in a RunSpec."""
        return cls(**{item.name: spec[f'analyzer.{item.name}'] for item in fields(cls)})  # type: ignore[arg-type]

    def floor(self, dof: str) -> float:
        """Base amplitude below which `dof` is not excited, m/s² or rad/s."""
        return self.floor_acceleration if dof in TRANSLATIONS else self.floor_rate


_DEFAULTS = TrackedSineSettings()

PARAMETERS = tuple(
    Parameter(
        f'analyzer.{item.name}',
        type(default),
        default,
        item.metadata['unit'],
        item.metadata['description'],
        *item.metadata['bounds'],
    )
    for item, default in zip(fields(_DEFAULTS), vars(_DEFAULTS).values(), strict=True)
)
