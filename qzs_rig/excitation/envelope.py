"""Cosine ramps and their exact product with a motion."""

from __future__ import annotations

import math

import numpy as np

from qzs_rig.samples import Array

Wave = tuple[Array, Array, Array]
"""A function of time with its first and second derivative, each (n,) or (n, c)."""


def fade_in(t: Array, ramp: float) -> Wave:
    """(1 - cos(pi t / ramp)) / 2 from 0 at t <= 0 to 1 at t >= ramp."""
    w = math.pi / ramp
    inside = (t > 0.0) & (t < ramp)
    sin, cos = np.sin(w * t), np.cos(w * t)
    level = np.where(inside, 0.5 * (1.0 - cos), (t >= ramp).astype(np.float64))
    return level, np.where(inside, 0.5 * w * sin, 0.0), np.where(inside, 0.5 * w * w * cos, 0.0)


def fade_out(t: Array, ramp: float) -> Wave:
    """The mirror of fade_in: 1 at t <= 0, 0 at t >= ramp."""
    level, slope, bend = fade_in(t, ramp)
    return 1.0 - level, -slope, -bend


def shaped(envelope: Wave, wave: Wave) -> Wave:
    """`envelope` times `wave` by the product rule."""
    e, de, dde = envelope
    x, dx, ddx = wave
    return e * x, de * x + e * dx, dde * x + 2.0 * de * dx + e * ddx
