"""Four degrees of freedom by themselves, by classical Runge-Kutta on the sample grid."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from qzs_rig.mechanics.compiling import kept
from qzs_rig.mechanics.platform import Platform
from qzs_rig.mechanics.restoring import law as restoring
from qzs_rig.mechanics.restoring.law import rsqrt
from qzs_rig.mechanics.stepping import Nodes, Stepper, by_kernel
from qzs_rig.samples import Array
from qzs_rig.units import DOFS


class Integrator(Stepper):
    """Fourth-order Runge-Kutta from sample to sample, starting at rest on the moving base.

    The top motion (n, 12) is position, velocity, acceleration. The interpreter and numba give the
    same bits.
    """

    columns = 12

    def __init__(self, platform: Platform, step: float, substeps: int, kernel: str) -> None:
        super().__init__(step, substeps)
        self._platform = platform
        law, dofs = platform.law, range(len(DOFS))
        fast = by_kernel(kernel, lambda: (compiled(law.count), restoring.compiled(law)))
        own: tuple[Any, Any] = fast or (march, [law.compilable(dof, rsqrt) for dof in dofs])
        self._march, self._forces = own
        self._lists = fast is None
        self._numbers = [law.numbers(platform.design, dof) for dof in dofs]
        self._scale = np.array(platform.length)
        # u, u' and u'' of each degree of freedom over length
        self._state: list[tuple[float, float, float]] = []

    def _begin(self, base: Array) -> Array:
        platform = self._platform
        base = base / np.tile(self._scale, 2)
        for dof, (force, load, w) in enumerate(
            zip(self._forces, platform.load, platform.rest, strict=True)
        ):
            rate = platform.stiffness[dof] / platform.mass[dof]
            # the top rides on the base; a law that does not balance there starts to slide at once
            ddu = -rate * (float(force(self._numbers[dof], w)) - load)
            self._state.append((float(base[dof]) + w, float(base[4 + dof]), ddu))
        top = np.array([value[order] for order in range(3) for value in self._state])
        return np.asarray(top * np.tile(self._scale, 3))

    def _advance(self, samples: Array) -> Array:
        nodes = self._nodes(samples / np.tile(self._scale, 2))
        top = np.empty((len(samples) - 1, self.columns))
        for dof in range(len(DOFS)):
            self._move(dof, nodes, top)
        return np.asarray(top * np.tile(self._scale, 3))

    def _move(self, dof: int, nodes: Nodes, top: Array) -> None:
        columns = [dof, 4 + dof, 8 + dof]
        ends, mid = nodes.ends, nodes.mid
        if not any(self._state[dof]) and not ends[:, [dof, 4 + dof]].any():
            top[:, columns] = 0.0  # at rest on a base at rest
            return
        lines = [
            np.ascontiguousarray(line)
            for line in (ends[:, dof], mid[:, dof], ends[:, 4 + dof], mid[:, 4 + dof])
        ]
        n = len(mid)
        out: list[Any] = [np.empty(n) for _ in range(3)]
        if self._lists:  # lists are four times as fast as arrays in the interpreter
            lines, out = [line.tolist() for line in lines], [[math.nan] * n for _ in range(3)]
        platform = self._platform
        try:
            good = self._march(
                self._forces[dof],
                self._numbers[dof],
                platform.damping[dof] / platform.mass[dof],
                platform.stiffness[dof] / platform.mass[dof],
                platform.load[dof],
                self._step / self._substeps,
                self._state[dof],
                *lines,
                *out,
            )
        except (ValueError, OverflowError, ZeroDivisionError):
            # math.sqrt of a negative number: outside the law's domain; what is unfilled is NaN
            good = n - int(np.count_nonzero(np.isnan(out[0])))
        if good < n:
            raise self._divergence(
                good // self._substeps,
                f'{DOFS[dof]} left the domain of law {platform.law.name} or the finite numbers',
                'lower excitation.amplitude, raise platform.substeps or the damping',
            )
        if n:
            self._state[dof] = (float(out[0][-1]), float(out[1][-1]), float(out[2][-1]))
            last = self._substeps - 1
            for column, line in zip(columns, out, strict=True):
                top[:, column] = line[last :: self._substeps]


def march(
    force: Any,
    numbers: Any,
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
    """Integrate u'' = -damping (u' - v') - stiffness (force(numbers, u - v) - load)
    in steps of h.

    `state` is (u, u', u'') at v[0]; base position and velocity stand at the n + 1 step ends
    (v, dv) and the n midpoints (v_mid, dv_mid). Fills u, du, ddu (n) at the step ends. Returns
    the number of good steps: less than n where the state left the finite numbers.
    """
    half, sixth = 0.5 * h, h / 6.0
    x, y, k1 = state
    for j in range(len(v_mid)):
        vm, dvm = v_mid[j], dv_mid[j]
        y2 = y + half * k1
        k2 = -damping * (y2 - dvm) - stiffness * (force(numbers, x + half * y - vm) - load)
        y3 = y + half * k2
        k3 = -damping * (y3 - dvm) - stiffness * (force(numbers, x + half * y2 - vm) - load)
        y4 = y + h * k3
        end, dend = v[j + 1], dv[j + 1]
        k4 = -damping * (y4 - dend) - stiffness * (force(numbers, x + h * y3 - end) - load)
        x = x + h * (y + sixth * (k1 + k2 + k3))
        y = y + sixth * (k1 + 2.0 * (k2 + k3) + k4)
        k1 = -damping * (y - dend) - stiffness * (force(numbers, x - end) - load)
        # also false for NaN
        if not abs(k1) < 1e300:
            return j
        u[j], du[j], ddu[j] = x, y, k1
    return len(v_mid)


@cache
def compiled(count: int) -> Any:
    """`march` compiled by numba for forces of `count` numbers, the same bits (no fast-math).

    Forces are passed as typed function pointers, so one compiled `march`, cached on disk,
    serves every law. Raises ImportError where numba cannot be imported.
    """
    from numba import float64, int64, types

    real, line = float64, float64[::1]
    # numba's own types carry no annotations
    pack: Any = types.UniTuple
    force = types.FunctionType(restoring.formula_type(count))
    lines = (line,) * 7
    signature = int64(force, pack(real, count), *(real,) * 4, pack(real, 3), *lines)
    return kept(signature)(march)
