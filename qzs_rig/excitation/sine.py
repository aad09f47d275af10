"""Sine dwell: one frequency, held."""

from __future__ import annotations

from qzs_rig.excitation.segments import Dwell, Segment
from qzs_rig.parameters import RunSpec, positive

PARAMETERS = (positive('excitation.frequency', 2.0, 'Hz', 'frequency of a sine dwell'),)


def plan(spec: RunSpec) -> tuple[Segment, ...]:
    """`excitation.duration` seconds at `excitation.frequency`."""
    return (Dwell(spec.number('excitation.frequency'), spec.number('excitation.duration')),)
