"""Sine dwell: one frequency, held."""

from __future__ import annotations

from qzs_rig.excitation.segments import Dwell, Segment
from qzs_rig.parameters import Parameter, RunSpec

PARAMETERS = (
    Parameter(
        'excitation.frequency', float, 2.0, 'Hz', 'frequency of a sine dwell', 0.0, above=True
    ),
)


def plan(spec: RunSpec) -> tuple[Segment, ...]:
    """`excitation.duration` seconds at `excitation.frequency`."""
    return (Dwell(spec.number('excitation.frequency'), spec.number('excitation.duration')),)
