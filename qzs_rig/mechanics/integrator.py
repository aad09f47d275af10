"""From base samples to top samples: what every integrator of a platform does alike, and the one of
four degrees of freedom by themselves, classical Runge-Kutta on the sample grid."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from qzs_rig.errors import DivergenceError, InputError
from qzs_rig.mechanics.compiling import kept
from qzs_rig.mechanics.platform import Platform
from qzs_rig.mechanics.restoring import law as restoring
from qzs_rig.mechanics.restoring.law import rsqrt
from qzs_rig.samples import Array
from qzs_rig.units import DOFS


class Nodes(NamedTuple):
    """Base position and velocity (., 8) at the step ends, the start first, and midpoints."""

    ends: Array
    mid: Array


class Stepper(ABC):
    """A plant stepped from sample to sample of its base, its state carried across chunks.

    The base motion between samples is the cubic through position and velocity at both ends:
    linear interpolation would drop the method to order 2. Time steps are `step` / `substeps` s.
    The output is bit by bit independent of how the motion is cut into chunks.
    """

    columns: int
    """Of the top motion."""

    def __init__(self, step: float, substeps: int) -> None:
        self._step, self._substeps = step, substeps
        self._base_end: Array | None = None
        self._last = 0  # index of the last base sample

    def push(self, base: Array) -> Array:
        """Absolute top motion (n, columns) for the base motion at the next samples.

        `base` is (n, >= 8): position, then velocity of the four degrees of freedom, SI, z up.
        Raises DivergenceError where the state leaves the finite numbers or the plant's limits.
        """
        top = np.empty((len(base), self.columns))
        if len(base) == 0:
            return top
        base, first = base[:, :8], 0
        if self._base_end is None:
            top[0] = self._begin(base[0])
            self._base_end, first = base[0].copy(), 1
        samples = np.vstack([self._base_end, base[first:]])
        top[first:] = self._advance(samples)
        self._base_end = base[-1].copy()
        self._last += len(base) - first
        return top

    @abstractmethod
    def _begin(self, base: Array) -> Array:
        """Top motion (columns,) riding on the base (8,) at the first sample."""

    @abstractmethod
    def _advance(self, samples: Array) -> Array:
        """Top motion (n, columns) at base samples (n + 1, 8), the last one known first."""

    def _nodes(self, samples: Array) -> Nodes:
        return hermite_nodes(samples, self._step, self._substeps)

    def _divergence(self, good: int, what: str, way_out: str) -> DivergenceError:
        sample = self._last + good
        return DivergenceError(
            f'{what} after sample {sample} ({sample * self._step:.3f} s); {way_out}', sample
        )


def hermite_nodes(samples: Array, step: float, substeps: int) -> Nodes:
    """The cubic through base position and velocity (n, 8), at step ends and midpoints."""
    x0, x1, v0, v1 = samples[:-1, :4], samples[1:, :4], samples[:-1, 4:], samples[1:, 4:]

    def at(s: float) -> Array:
        position = (
            (1 + 2 * s) * (1 - s) ** 2 * x0
            + s * s * (3 - 2 * s) * x1
            + step * (s * (1 - s) ** 2 * v0 + s * s * (s - 1) * v1)
        )
        velocity = 6 * s * (1 - s) * (x1 - x0) / step + (1 - s) * (1 - 3 * s) * v0
        return np.hstack([position, velocity + s * (3 * s - 2) * v1])

    n = len(x0)
    mid = np.stack([at((j + 0.5) / substeps) for j in range(substeps)], axis=1)
    inner = [at((j + 1.0) / substeps) for j in range(substeps - 1)]
    ends = np.stack([*inner, samples[1:]], axis=1).reshape(n * substeps, 8)
    return Nodes(np.vstack([samples[:1], ends]), mid.reshape(n * substeps, 8))


def by_kernel(kernel: str, compiled: Callable[[], Any]) -> Any:
    """What `compiled` returns, or None for the interpreter: platform.kernel 'python', or 'auto'
    where numba cannot be imported. Raises InputError where it was asked for."""
    if kernel == 'python':
        return None
    try:
        return compiled()
    except ImportError:
        if kernel == 'auto':
            return None
        raise InputError(
            "platform.kernel = 'numba' needs numba; pip install numba or set platform.kernel to "
            'auto'
        ) from None


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
