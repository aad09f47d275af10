"""Swept sine: the frequency runs from one end of the band to the other, and back if asked."""

from __future__ import annotations

from qzs_rig.errors import InputError
from qzs_rig.excitation.segments import LinearChirp, LogChirp, Segment
from qzs_rig.parameters import Parameter, RunSpec

PARAMETERS = (
    Parameter(
        'excitation.spacing',
        str,
        'linear',
        '',
        'frequency linear in time, or logarithmic (equal time an octave)',
        choices=('linear', 'log'),
    ),
)


def plan(spec: RunSpec) -> tuple[Segment, ...]:
    """`excitation.duration` seconds in all; there_and_back spends half of it each way."""
    low, high = band(spec)
    duration = spec.number('excitation.duration')
    chirp = LinearChirp if spec.text('excitation.spacing') == 'linear' else LogChirp
    match spec.text('excitation.direction'):
        case 'forward':
            return (chirp(low, high, duration),)
        case 'reverse':
            return (chirp(high, low, duration),)
        case _:
            return (chirp(low, high, duration / 2), chirp(high, low, duration / 2))


def band(spec: RunSpec) -> tuple[float, float]:
    """Lower and upper frequency in Hz; raises InputError unless lower < upper."""
    low, high = spec.number('excitation.frequency_low'), spec.number('excitation.frequency_high')
    if low >= high:
        raise InputError(
            f'excitation.frequency_low = {low:g} Hz is not below frequency_high = {high:g} Hz; '
            'for a downward sweep set excitation.direction to reverse'
        )
    return low, high
