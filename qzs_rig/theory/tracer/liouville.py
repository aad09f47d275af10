"""Stability of one oscillator's periodic motion: the trace of its monodromy matrix.

The determinant is known (Liouville: exp(-2 ζ T)), so the trace gives both Floquet multipliers.
Taken out of z = e^(ζ τ) δw, the damping leaves Hill's equation z'' + (k - ζ²) z = 0, which
Numerov's recurrence (Hairer, Norsett, Wanner, section III.10) integrates to fourth order from
samples of the stiffness, and Richardson's extrapolation to sixth.

Written once for the interpreter and numba.
"""

from __future__ import annotations

import math
from typing import Any

from qzs_rig.theory.tracer.balancing import synthesise

RESOLVED = 0.01
"""h² max |k|, which leaves about 1e-8 in the trace."""


def monodromies(
    sample: Any, motion: Any, scratch: Any, finest: int, path: Any, count: int, traces: Any
) -> None:
    """Fill `traces` at the first `count` points of path (., 2H + 2)."""
    level = 1
    for i in range(count):
        level = max(1, level - 1)
        resolved = resolution(sample, motion, scratch, level, path[i])
        while resolved > RESOLVED and level < finest:
            level += 1
            resolved = resolution(sample, motion, scratch, level, path[i])
        samples, omega = scratch.coarsest << level, path[i][len(path[i]) - 1]
        for every in range(1, 3):
            found = trace_of(motion, scratch, samples, every, omega)
            traces[i] = found if every == 1 else (16.0 * traces[i] - found) / 15.0


def resolution(sample: Any, motion: Any, scratch: Any, level: int, y: Any) -> float:
    """Fill `k` with the stiffness along the motion y; its maximum times h²."""
    count, largest = scratch.coarsest << level, 0.0
    synthesise(scratch, count - scratch.coarsest, count, y)
    sample(motion.numbers, motion.load, count, scratch.w, scratch.f, scratch.k)
    for j in range(count):
        largest = max(largest, abs(scratch.k[j]))
    h = 2.0 * math.pi / (y[len(y) - 1] * count)
    return float(h * h * largest)


def trace_of(motion: Any, scratch: Any, count: int, every: int, omega: float) -> float:
    """Numerov's trace from every first or second of `count` samples of `k`."""
    h = 2.0 * math.pi * every / (omega * count)
    square, decay = h * h, math.exp(-motion.zeta * h)
    rest, still = decay * decay, motion.zeta * motion.zeta
    a, a_before, b, b_before = 1.0, 0.0, 0.0, 1.0
    for j in range(0, count, every):
        q = square * (scratch.k[j] - still)
        g = decay * (2.0 - q / (1.0 + q / 12.0))
        a, a_before = g * a - rest * a_before, a
        b, b_before = g * b - rest * b_before, b
    return a + b_before
