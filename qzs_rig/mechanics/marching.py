"""Classical Runge-Kutta over one degree of freedom, written once for the interpreter and numba."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from qzs_rig.mechanics.restoring import RESTORING, bulk
from qzs_rig.mechanics.restoring.roots import rsqrt

March = Callable[..., Any]


def march(
    force: Any,
    design: Any,
    damping: float,
    stiffness: float,
    load: float,
    h: float,
    state: Any,
    v: Any,
    v_mid: Any,
    dv: Any,
    dv_mid: Any,
    u: Any,
    du: Any,
    ddu: Any,
) -> int:
    """Integrate u'' = -damping (u' - v') - stiffness (force(u - v) - load) in steps of h.

    `state` is (u, u', u'') at v[0]; base position and velocity stand at the n + 1 step ends
    (v, dv) and the n midpoints (v_mid, dv_mid). Fills u, du, ddu (n) at the step ends. Returns
    the number of good steps: less than n where the state left the finite numbers.
    """
    half, sixth = 0.5 * h, h / 6.0
    x, y, k1 = state
    for j in range(len(v_mid)):
        vm, dvm = v_mid[j], dv_mid[j]
        y2 = y + half * k1
        k2 = -damping * (y2 - dvm) - stiffness * (force(design, x + half * y - vm) - load)
        y3 = y + half * k2
        k3 = -damping * (y3 - dvm) - stiffness * (force(design, x + half * y2 - vm) - load)
        y4 = y + h * k3
        end, dend = v[j + 1], dv[j + 1]
        k4 = -damping * (y4 - dend) - stiffness * (force(design, x + h * y3 - end) - load)
        x = x + h * (y + sixth * (k1 + k2 + k3))
        y = y + sixth * (k1 + 2.0 * (k2 + k3) + k4)
        k1 = -damping * (y - dend) - stiffness * (force(design, x - end) - load)
        # also false for NaN
        if not abs(k1) < 1e300:
            return j
        u[j], du[j], ddu[j] = x, y, k1
    return len(v_mid)


@cache
def interpreted(law: str) -> tuple[March, tuple[Any, ...]]:
    """`march` and the four formulas of a law for the plain interpreter."""
    return march, RESTORING[law].around(rsqrt)


@cache
def compiled(law: str) -> tuple[March, tuple[Any, ...]]:
    """`march` and the four formulas of a law compiled by numba, the same bits (no fast-math).

    Formulas are passed as typed function pointers, so one compiled `march`, cached on disk,
    serves every law. Raises ImportError where numba is not installed.
    """
    from numba import float64, int64, njit, types

    real, line = float64, float64[::1]
    # numba's own types carry no annotations
    pack: Any = types.UniTuple
    signature = int64(
        types.FunctionType(bulk.formula_type()),
        pack(real, 6),
        *(real,) * 4,
        pack(real, 3),
        *(line,) * 7,
    )
    fast = njit(signature, cache=True, nogil=True)(march)
    return fast, bulk.compiled(RESTORING[law].around)
