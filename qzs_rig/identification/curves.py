"""Measured curves from an estimate: which of its points are steady, and how fast it swept."""

from __future__ import annotations

import math

import numpy as np

from qzs_rig.estimation.estimate import Curve, Estimate
from qzs_rig.estimation.events import RINGING, find_jumps
from qzs_rig.identification.points import Points
from qzs_rig.parameters import RunSpec
from qzs_rig.samples import Array

SETTLED = 'stepped_sine'
"""The estimator whose points have settled; any other followed a sine on the move."""
WINDOW = 4.0
"""Periods of an analysis window, and of its distance to the next, where the estimate says none."""


def measured(estimate: Estimate, spec: RunSpec) -> list[Points]:
    """The usable points of every curve.

    Of a sweep the transition at a jump and the free vibration after it are left out, and of the
    rest only windows are kept that share no sample: the others would repeat their noise. The
    uncertainty of an estimate counts smoothing within a window, which is no noise: left out.
    """
    told = estimate.quality.get('settings', {})
    apart = math.ceil(told.get('periods', WINDOW) / told.get('hop_periods', WINDOW))
    return [_points(curve, spec, apart) for curve in estimate.curves]


def sweep_rate(spec: RunSpec, frequency_hz: Array, direction: str) -> Array:
    """Rate of the sweep at `frequency_hz` (n,) in Hz/s, signed; 0 where the run did not sweep.

    The eases at the ends of the band are left out of account: they are slower.
    """
    if spec.text('excitation.kind') != 'sweep' or direction == 'none':
        return np.zeros(len(frequency_hz))
    low, high = spec.number('excitation.frequency_low'), spec.number('excitation.frequency_high')
    ways = 2 if spec.text('excitation.direction') == 'there_and_back' else 1
    each = spec.number('excitation.duration') / ways
    sign = 1.0 if direction == 'forward' else -1.0
    if spec.text('excitation.spacing') == 'log':
        return sign * math.log(high / low) / each * frequency_hz
    return np.full(len(frequency_hz), sign * (high - low) / each)


def _points(curve: Curve, spec: RunSpec, apart: int) -> Points:
    keep = np.isfinite(curve.magnitude) & (curve.magnitude > 0)
    settled = curve.estimator == SETTLED
    if not settled and len(keep) >= 3:
        for jump in find_jumps(curve):
            keep[jump.first : jump.last + RINGING] = False
    which = np.flatnonzero(keep)
    if not settled:
        which = which[:: max(apart, 1)]
    n = len(which)
    frequency_hz = curve.frequency_hz[which]
    return Points(
        curve.dof,
        np.full(n, curve.direction),
        frequency_hz,
        curve.magnitude[which],
        np.radians(curve.phase_deg[which]),
        np.full(n, np.nan),
        np.zeros(n) if settled else sweep_rate(spec, frequency_hz, curve.direction),
    )
