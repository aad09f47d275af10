"""Stepped sine: dwells on a grid of frequencies, joined by glides."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from qzs_rig.excitation.segments import Dwell, Glide, Segment
from qzs_rig.excitation.sweep import band
from qzs_rig.parameters import Parameter, RunSpec, positive

PARAMETERS = (
    Parameter('excitation.steps', int, 16, '', 'frequencies in a stepped sine, each way', 2, 10000),
    positive('excitation.dwell', 20.0, 's', 'time on each frequency of a stepped sine'),
    positive('excitation.glide', 1.0, 's', 'time from one frequency to the next'),
)


def plan(spec: RunSpec) -> tuple[Segment, ...]:
    """Dwells from low to high (forward), high to low (reverse) or both, linear or log spaced."""
    low, high = band(spec)
    space = np.linspace if spec.text('excitation.spacing') == 'linear' else np.geomspace
    up = [float(hz) for hz in space(low, high, spec.count('excitation.steps'))]
    down = up[::-1]
    frequencies = {'forward': up, 'reverse': down, 'there_and_back': up + down[1:]}[
        spec.text('excitation.direction')
    ]
    dwell, glide = spec.number('excitation.dwell'), spec.number('excitation.glide')
    segments: list[Segment] = [Dwell(frequencies[0], dwell)]
    for here, there in pairwise(frequencies):
        segments += [Glide(here, there, glide), Dwell(there, dwell)]
    return tuple(segments)
