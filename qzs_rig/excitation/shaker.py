"""What the shaker can do (paper, Table 4), and the refusal of what it cannot."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from qzs_rig.errors import LimitError
from qzs_rig.excitation.drive import Drive
from qzs_rig.parameters import Parameter, RunSpec, positive
from qzs_rig.units import DOFS, TRANSLATIONS

PARAMETERS = (
    Parameter('shaker.limits', bool, True, '', 'refuse a run that the shaker could not perform'),
    positive('shaker.force', 22e3, 'N', 'peak force (Table 4)'),
    positive('shaker.acceleration', 1000.0, 'm/s²', 'peak acceleration (Table 4)'),
    positive('shaker.velocity', None, 'm/s', 'peak velocity, if known'),
    positive('shaker.displacement', None, 'm', 'peak displacement, if known'),
    Parameter('shaker.frequency_low', float, 1.0, 'Hz', 'lowest frequency (Table 4)', 0.0),
    Parameter('shaker.frequency_high', float, 3000.0, 'Hz', 'highest frequency (Table 4)', 0.0),
)

_BLOCK = 1 << 16


def refuse_beyond_limits(drive: Drive, spec: RunSpec) -> None:
    """Raises LimitError listing every limit of the shaker that the drive would break.

    Translations only: Table 4 has no torque. The force is that on the payload as a rigid mass.
    """
    if not spec.flag('shaker.limits'):
        return
    reasons = [*_frequency_reasons(drive, spec), *_amplitude_reasons(drive, spec)]
    if reasons:
        raise LimitError(
            f'the shaker cannot do this run: {"; ".join(reasons)}. Lower excitation.amplitude, '
            'narrow the band, or lift the limits with --set shaker.limits=false'
        )


def _frequency_reasons(drive: Drive, spec: RunSpec) -> list[str]:
    edges = [
        float(hz)
        for segment in drive.segments
        for hz in segment.cycles(np.array([0.0, segment.duration])).frequency
    ]
    low, high = spec.number('shaker.frequency_low'), spec.number('shaker.frequency_high')
    reasons = []
    if min(edges) < low * (1.0 - 1e-9):
        reasons.append(f'{min(edges):g} Hz is below its {low:g} Hz')
    if max(edges) > high * (1.0 + 1e-9):
        reasons.append(f'{max(edges):g} Hz is above its {high:g} Hz')
    return reasons


def _amplitude_reasons(drive: Drive, spec: RunSpec) -> list[str]:
    displacement, velocity, acceleration = _peaks(drive).reshape(3, 4)
    reasons = []
    for column, dof in enumerate(TRANSLATIONS):
        force = acceleration[column] * spec.number('platform.m')
        for value, name, unit in (
            (displacement[column], 'displacement', 'm'),
            (velocity[column], 'velocity', 'm/s'),
            (acceleration[column], 'acceleration', 'm/s²'),
            (force, 'force', 'N'),
        ):
            limit = spec.optional(f'shaker.{name}')
            if limit is not None and value > limit:
                reasons.append(f'{dof} {name} reaches {value:.4g} {unit}, beyond {limit:g} {unit}')
    return reasons


@lru_cache(maxsize=1)  # an exciter weighs its plan when it is configured and when it begins
def _peaks(drive: Drive) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    peak = np.zeros(3 * len(DOFS))
    for first in range(0, drive.samples, _BLOCK):
        block = drive.motion(first, min(first + _BLOCK, drive.samples))
        peak = np.maximum(peak, np.abs(block).max(axis=0))
    return peak
