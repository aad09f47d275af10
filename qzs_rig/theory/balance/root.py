"""A zero of a function of one number."""

from __future__ import annotations

import math
from collections.abc import Callable


def root(value: Callable[[float], float]) -> float | None:
    """Zero in [0, 1] by the Illinois method; None without a change of sign, or at a NaN."""
    a, b = 0.0, 1.0
    fa, fb = value(a), value(b)
    if not fa * fb < 0:
        return a if fa == 0 else b if fb == 0 else None
    for _ in range(60):
        c = (a * fb - b * fa) / (fb - fa)
        fc = value(c)
        if not math.isfinite(fc):
            return None
        if fc * fb < 0:
            a, fa = b, fb
        else:
            fa *= 0.5
        step, b, fb = abs(c - b), c, fc
        if fc == 0 or step < 1e-12 or abs(a - b) < 1e-14:
            break
    return b
