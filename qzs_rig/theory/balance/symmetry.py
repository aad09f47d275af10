"""Half-wave symmetry: an odd law lets motions mirror themselves every half period, or come in pairs
that are each other's mirror image."""

from __future__ import annotations

import numpy as np

from qzs_rig.samples import Array
from qzs_rig.theory.oscillator import Oscillator


def symmetric(oscillator: Oscillator) -> bool:
    """Is the law odd, and nothing loads it off its middle?"""
    w = min(1.0, 0.9 * oscillator.domain) * np.linspace(0.05, 1.0, 7)
    force = oscillator.force(w)
    return bool(np.all(np.abs(force + oscillator.force(-w)) <= 1e-14 * np.abs(force)))


def mirrored(coefficients: Array) -> Array:
    """The motion (2H + 1,) upside down and half a period later: even orders change sign."""
    return coefficients * _signs(len(coefficients))


def even_part(coefficients: Array) -> Array:
    """The even harmonics of a motion (2H + 1,), the others 0."""
    return np.asarray(np.where(_signs(len(coefficients)) < 0, coefficients, 0.0))


def lopsided(coefficients: Array) -> float:
    """What even harmonics are of the whole (2H + 1,)."""
    whole = float(np.linalg.norm(coefficients)) or 1.0
    return float(np.linalg.norm(even_part(coefficients))) / whole


def _signs(size: int) -> Array:
    order = (np.arange(size) + 1) // 2
    return np.where(order % 2 == 0, -1.0, 1.0)
