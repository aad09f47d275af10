"""How well a measured transmissibility is known: noise of the fits, and T that does not rest.

Both are relative standard uncertainties of |T|, independent of each other, so their squares add
(JCGM 100:2008, 5.1). What they do not know: a sensor's calibration, the other axes in the signal,
and the lag of a sweep that outruns the platform's memory.
"""

from __future__ import annotations

import math

import numpy as np

from qzs_rig.estimation.tracker import Point
from qzs_rig.samples import Array

FIT = 2.0
"""A fundamental fitted with a moving envelope under the weight (1 - u²)² scatters twice as much
as one of constant amplitude in the same white noise, which scatters by residual / sqrt(samples)."""


def noise(point: Point) -> float:
    """From what the fits of base and top left over, as if it were white."""
    return FIT * math.hypot(point.base_residual, point.top_residual) / math.sqrt(point.samples)


def unrest(time_s: Array, frequency_hz: Array, magnitude: Array, periods: float) -> Array:
    """From the change of T (n,) within half a window of `periods`: the point stands for any moment
    of it alike (a rectangular distribution, JCGM 100:2008, 4.3.7). 0 for a single point."""
    if len(time_s) < 2:
        return np.zeros(len(time_s))
    with np.errstate(divide='ignore', invalid='ignore'):
        rate = np.gradient(np.log(magnitude), time_s)
    return np.asarray(np.abs(rate) * 0.5 * periods / frequency_hz / math.sqrt(3.0))
