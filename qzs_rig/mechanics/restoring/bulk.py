"""One law over many points: compiled threads, or numpy where numba cannot be imported.

Both give the same bits.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

import numpy as np

from qzs_rig.mechanics.compiling import kept
from qzs_rig.mechanics.design import Design
from qzs_rig.mechanics.restoring.roots import Root, reciprocal, rsqrt, teach_numba
from qzs_rig.samples import Array

Around = Callable[[Root], tuple[Any, ...]]

MANY = 200_000
"""Values from which threads are worth waking."""
BLOCK = 65_536
"""Rows a task: few enough to share out evenly, many enough that handing out costs nothing."""


def evaluated(around: Around, design: Design, w: Array) -> Array:
    """The four formulas of `around` at w (..., 4) -> (..., 4)."""
    fill = kernel() if w.size >= MANY and w.dtype == np.float64 else None
    if fill is None:
        return in_numpy(around, design, w)
    formulas, rows, out = compiled(around), w.reshape(-1, 4), np.empty((w.size // 4, 4))
    ratios = tuple(design)

    def block(k: int) -> None:
        fill(*formulas, ratios, rows[k : k + BLOCK], out[k : k + BLOCK])

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(block, range(0, len(rows), BLOCK)))
    return out.reshape(w.shape)


def in_numpy(around: Around, design: Design, w: Array) -> Array:
    """What `evaluated` gives without numba."""
    return np.stack(
        [f(design, w[..., k]) for k, f in enumerate(around(reciprocal(np.sqrt)))], axis=-1
    )


@cache
def compiled(around: Around) -> tuple[Any, ...]:
    """The four formulas compiled by numba (no fast-math); ImportError where it is missing."""
    teach_numba()
    return tuple(kept(formula_type(), error_model='numpy')(plain) for plain in around(rsqrt))


def formula_type() -> Any:
    """numba's type of a compiled formula: design and w to a number."""
    from numba import float64, types

    # numba's own types carry no annotations
    pack: Any = types.UniTuple
    return float64(pack(float64, 6), float64)


@cache
def kernel() -> Any:
    """Rows of w through four function pointers, so that one compiled loop serves every law."""
    try:
        from numba import float64, types, void
    except ImportError:
        return None
    pack: Any = types.UniTuple
    pointer = types.FunctionType(formula_type())
    rows = float64[:, :]
    signature = void(*(pointer,) * 4, pack(float64, 6), rows, rows)
    return kept(signature)(_fill)


def _fill(f0: Any, f1: Any, f2: Any, f3: Any, design: Any, w: Any, out: Any) -> None:
    for k in range(len(w)):
        out[k, 0] = f0(design, w[k, 0])
        out[k, 1] = f1(design, w[k, 1])
        out[k, 2] = f2(design, w[k, 2])
        out[k, 3] = f3(design, w[k, 3])
