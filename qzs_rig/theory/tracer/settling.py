"""A first motion by waiting: the oscillator is integrated until its transient has died down.

Written once for the interpreter and numba. Newton has nothing to start from at low frequency: a
QZS law has no stiffness at w = 0.
"""

from __future__ import annotations

import math
from typing import Any

from qzs_rig.theory.tracer.balancing import analyse, drive

STEP = 0.05
"""Of the classical Runge-Kutta in τ: stable up to stiffness 3000. Newton does the rest."""


def settle(sample: Any, motion: Any, scratch: Any, y: Any) -> None:
    """Let y run on for two decay times, and turn its last period into coefficients."""
    n, count, w = len(y) - 1, scratch.coarsest, scratch.w
    omega, x, v = y[n], y[0], 0.0
    for c in range(1, n, 2):
        x += y[c]
        v += 0.5 * (c + 1) * omega * y[c + 1]
    period = 2.0 * math.pi / omega
    parts = math.ceil(period / count / STEP)
    h = period / count / parts
    periods = min(100, math.ceil(2.0 / (motion.zeta * period + 0.02)))
    for _ in range(periods):
        for j in range(count):
            w[j] = x
            for part in range(parts):
                x, v = advance(sample, motion, scratch, omega, (j * parts + part) * h, h, x, v)
    analyse(scratch, w, 0, count, y, n, 2.0 / count)
    y[0] *= 0.5


def advance(
    sample: Any, motion: Any, scratch: Any, omega: float, t: float, h: float, x: float, v: float
) -> tuple[float, float]:
    """Position and velocity a step later."""
    half, ahead = 0.5 * h, t + 0.5 * h
    a1 = acceleration(sample, motion, scratch, omega, t, x, v)
    v2 = v + half * a1
    a2 = acceleration(sample, motion, scratch, omega, ahead, x + half * v, v2)
    v3 = v + half * a2
    a3 = acceleration(sample, motion, scratch, omega, ahead, x + half * v2, v3)
    v4 = v + h * a3
    a4 = acceleration(sample, motion, scratch, omega, t + h, x + h * v3, v4)
    x += h / 6.0 * (v + 2.0 * (v2 + v3) + v4)
    v += h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)
    return x, v


def acceleration(
    sample: Any, motion: Any, scratch: Any, omega: float, t: float, x: float, v: float
) -> float:
    """w'' at a time, from the oscillator's equation."""
    w, f, k = scratch.along, scratch.guess, scratch.weight
    w[0] = x
    sample(motion.numbers, motion.load, 1, w, f, k)
    push = drive(motion, omega) * math.cos(omega * t)
    return float(push - 2.0 * motion.zeta * v - f[0])
