"""The scenario that puts a proposal to the test: a slow sweep through its onset and back."""

from __future__ import annotations

from typing import Any

from qzs_rig import scenario
from qzs_rig.advisor.proposal import Proposal
from qzs_rig.parameters import RunSpec

BELOW, ABOVE = 0.4, 2.5
"""Band over the onset."""
PERIODS = 100.0
"""Periods of the onset frequency an octave."""
OCTAVES = 2.65
"""log2(ABOVE/BELOW)."""
SAMPLES = 125.0
"""A period of the highest frequency."""


def trial(p: Proposal) -> RunSpec:
    """A logarithmic sweep there and back at the level of the wish, with an ideal sensor.

    The band is around the onset that theory gives, or the wanted one where T < 1 throughout.
    A shaker that starts at 1 Hz has its limit moved down to the band.
    """
    onset = p.motion.response().onset or p.wish.onset
    low, high = BELOW * onset, ABOVE * onset
    values: dict[str, Any] = {
        'run.rate': float(round(SAMPLES * high)) or 1.0,
        'excitation.kind': 'sweep',
        'excitation.direction': 'there_and_back',
        'excitation.spacing': 'log',
        'excitation.frequency_low': low,
        'excitation.frequency_high': high,
        'excitation.duration': 2.0 * OCTAVES * PERIODS / onset,
        'excitation.ramp': 6.0 / low,
        'excitation.quantity': p.wish.held,
        'excitation.amplitude.vertical': p.wish.level,
        'platform.law': 'corrected',
        **{f'platform.{name}': getattr(p, name) for name in ('k1', 'k2', 'k3', 'L1', 'L20', 'L0')},
        'platform.m': p.wish.mass,
        'platform.zeta': p.wish.zeta,
        'sensor.kind': 'ideal',
    }
    if low < 1.0:
        values['shaker.frequency_low'] = low
    return scenario.of(values)


def text(p: Proposal) -> str:
    """The scenario file: what it is for, then the parameters."""
    wish = p.wish
    level = f'{wish.level:g} {"m/s²" if wish.held == "acceleration" else "m"}'
    head = (
        f'# Proposed by qzs-rig design: {wish.mass:g} kg, onset {wish.onset:g} Hz or below at '
        f'{level}, stroke {wish.stroke:g} m, zeta {wish.zeta:g}.\n'
    )
    return head + trial(p).to_yaml()
