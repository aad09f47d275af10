"""Swept sine: the frequency runs from one end of the band to the other, and back if asked."""

from __future__ import annotations

import math

from qzs_rig.errors import InputError
from qzs_rig.excitation.segments import Ease, LinearChirp, LogChirp, Segment
from qzs_rig.parameters import Parameter, RunSpec, positive

PARAMETERS = (
    Parameter(
        'excitation.spacing',
        str,
        'linear',
        '',
        'frequency linear in time, or logarithmic (equal time an octave)',
        choices=('linear', 'log'),
    ),
    positive(
        'excitation.ease',
        1.0,
        's',
        'time in which a sweep takes up its rate, and gives it up at the end of the band; '
        'at most a quarter of a way',
    ),
)


def plan(spec: RunSpec) -> tuple[Segment, ...]:
    """`excitation.duration` seconds in all; there_and_back spends half of it each way."""
    low, high = band(spec)
    duration = spec.number('excitation.duration')
    ways = {
        'forward': [(low, high)],
        'reverse': [(high, low)],
        'there_and_back': [(low, high), (high, low)],
    }[spec.text('excitation.direction')]
    one_way = _linear if spec.text('excitation.spacing') == 'linear' else _log
    each = duration / len(ways)
    ease = min(spec.number('excitation.ease'), each / 4.0)
    return tuple(segment for start, end in ways for segment in one_way(start, end, each, ease))


def _linear(start: float, end: float, duration: float, ease: float) -> tuple[Segment, ...]:
    # Without the eases a held velocity or acceleration bends its displacement amplitude at the
    # ends of the sweep, which is a step of the velocity.
    rate = (end - start) / (duration - ease)
    take_up = Ease(start, 0.0, rate, ease)
    reached = end - 0.5 * rate * ease
    chirp = LinearChirp(take_up.end_hz, reached, duration - 2.0 * ease)
    return (take_up, chirp, Ease(reached, rate, 0.0, ease))


def _log(start: float, end: float, duration: float, ease: float) -> tuple[Segment, ...]:
    def bounds(growth: float) -> tuple[float, float]:
        return start / (1.0 - 0.5 * growth * ease), end / (1.0 + 0.5 * growth * ease)

    growth = math.log(end / start) / duration
    for _ in range(60):  # a contraction: the eases change the growth by little
        first, last = bounds(growth)
        growth = math.log(last / first) / (duration - 2.0 * ease)
    first, last = bounds(growth)
    return (
        Ease(start, 0.0, growth * first, ease),
        LogChirp(first, last, duration - 2.0 * ease),
        Ease(last, growth * last, 0.0, ease),
    )


def band(spec: RunSpec) -> tuple[float, float]:
    """Lower and upper frequency in Hz; raises InputError unless lower < upper."""
    low, high = spec.number('excitation.frequency_low'), spec.number('excitation.frequency_high')
    if low >= high:
        raise InputError(
            f'excitation.frequency_low = {low:g} Hz is not below frequency_high = {high:g} Hz; '
            'for a downward sweep set excitation.direction to reverse'
        )
    return low, high
