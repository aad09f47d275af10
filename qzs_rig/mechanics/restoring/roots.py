"""Reciprocal square roots: what the restoring laws are written around."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

Root = Callable[[Any], Any]


def rsqrt(q: Any) -> Any:
    """1/sqrt(q) of a number, the same bits in the interpreter and compiled."""
    return 1.0 / math.sqrt(q)


def fast_rsqrt(q: Any) -> Any:
    """1/sqrt(q) to 2e-14 for 1e-37 < q < 1e37: single precision and one Newton step.

    Only compiled code gains: processors estimate the single root without dividing.
    """
    r = np.float64(np.float32(1.0) / np.sqrt(np.float32(q)))
    return r * (1.5 - (0.5 * q) * (r * r))


def reciprocal(sqrt: Root) -> Root:
    """1/sqrt(q) by any square root: numpy's for arrays, cmath's for complex numbers."""
    return lambda q: 1.0 / sqrt(q)


@cache
def teach_numba() -> None:
    """Let numba compile both roots where a law calls them; ImportError where it is missing."""
    from numba.extending import register_jitable

    register_jitable(error_model='numpy')(rsqrt)
    register_jitable(error_model='numpy', fastmath={'contract', 'arcp', 'afn'})(fast_rsqrt)
