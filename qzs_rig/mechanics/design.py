"""The nondimensional design of a platform: four ratios that fix every restoring law."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np


def root(x: Any) -> Any:
    """Square root of a float, or of each of (n,)."""
    return math.sqrt(x) if isinstance(x, float) else np.sqrt(x)


class Design(NamedTuple):
    """Stiffness and length ratios of the paper's section 3; a and b follow from the first four.

    A = k2/k1, k3 = k3/k1, L1 = L1/L20 < 1, L0 = L0/L20, a = sqrt(1 - L1²), b = k3 L1. Each is a
    float, or (n,) for as many designs; formulas take either.
    """

    A: float
    k3: float
    L1: float
    L0: float
    a: float
    b: float

    @classmethod
    def of(cls, A: float, k3: float, L1: float, L0: float) -> Design:
        """The design with its derived ratios."""
        return cls(A, k3, L1, L0, root(1.0 - L1 * L1), k3 * L1)


PAPER_DESIGN = Design.of(A=1.1, k3=0.1, L1=math.sqrt(3.0) / 2.0, L0=0.1)
"""The paper's choice after Figure 9 (A = 1.1, k3 = 0.1, L1 = sqrt(3)/2, L0 = 0.1)."""
