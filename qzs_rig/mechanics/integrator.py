"""Fixed-step integration of the platform on the sample grid, its state carried across chunks."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from qzs_rig.errors import DivergenceError, InputError
from qzs_rig.mechanics import marching
from qzs_rig.mechanics.platform import Platform
from qzs_rig.samples import Array
from qzs_rig.units import DOFS


class Integrator:
    """Fourth-order Runge-Kutta from sample to sample, starting at rest on the moving base.

    The base motion between samples is the cubic through position and velocity at both ends:
    linear interpolation would drop the method to order 2. Time steps are `step` / `substeps` s.
    The output is bit by bit independent of how the motion is cut into chunks.
    """

    def __init__(self, platform: Platform, step: float, substeps: int, kernel: str) -> None:
        self._platform = platform
        self._step = step
        self._substeps = substeps
        self._march, self._formulas, self._lists = _kernel(platform.law.name, kernel)
        self._scale = np.array(platform.length)
        # u, u' and u'' of each degree of freedom over length, and the last base sample (8,)
        self._state: list[tuple[float, float, float]] = []
        self._base_end: Array | None = None
        self._last = 0  # its index

    def push(self, base: Array) -> Array:
        """Absolute top motion for the base motion at the next samples.

        `base` is (n, >= 8): position, then velocity of the four degrees of freedom, SI, z up.
        Returns (n, 12): position, velocity, acceleration. Raises DivergenceError, naming the
        degree of freedom, where the state is no longer finite.
        """
        if len(base) == 0:
            return np.empty((0, 12))
        base = base[:, :8] / np.tile(self._scale, 2)
        top = np.empty((len(base), 12))
        first = 0
        if self._base_end is None:
            top[0] = self._rest(base[0])
            self._base_end, first = base[0], 1
        nodes = hermite_nodes(np.vstack([self._base_end, base[first:]]), self._step, self._substeps)
        for dof in range(len(DOFS)):
            self._advance(dof, nodes, top[first:])
        self._base_end = base[-1]
        self._last += len(base) - first
        return np.asarray(top * np.tile(self._scale, 3))

    def _rest(self, base: Array) -> Array:
        platform = self._platform
        for dof, (formula, load, w) in enumerate(
            zip(self._formulas, platform.load, platform.rest, strict=True)
        ):
            rate = platform.stiffness[dof] / platform.mass[dof]
            # the top rides on the base; a law that does not balance there starts to slide at once
            ddu = -rate * (float(formula(tuple(platform.design), w)) - load)
            self._state.append((float(base[dof]) + w, float(base[4 + dof]), ddu))
        return np.array([value[order] for order in range(3) for value in self._state])

    def _advance(self, dof: int, nodes: Nodes, top: Array) -> None:
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
                self._formulas[dof],
                tuple(platform.design),
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
            raise self._divergence(dof, good // self._substeps)
        if n:
            self._state[dof] = (float(out[0][-1]), float(out[1][-1]), float(out[2][-1]))
            last = self._substeps - 1
            for column, line in zip(columns, out, strict=True):
                top[:, column] = line[last :: self._substeps]

    def _divergence(self, dof: int, good: int) -> DivergenceError:
        sample = self._last + good
        return DivergenceError(
            f'{DOFS[dof]} left the domain of law {self._platform.law.name} or the finite numbers '
            f'after sample {sample} ({sample * self._step:.3f} s); lower excitation.amplitude, '
            'raise platform.substeps or the damping',
            sample,
        )


class Nodes:
    """Base position and velocity (., 8) at the step ends and midpoints."""

    def __init__(self, ends: Array, mid: Array) -> None:
        self.ends, self.mid = ends, mid


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


def _kernel(law: str, kernel: str) -> tuple[Any, tuple[Any, ...], bool]:
    if kernel != 'python':
        try:
            march, formulas = marching.compiled(law)
            return march, formulas, False
        except ImportError:
            if kernel == 'numba':
                raise InputError(
                    "platform.kernel = 'numba' needs numba; pip install 'qzs_rig[fast]' "
                    'or set platform.kernel to auto'
                ) from None
    march, formulas = marching.interpreted(law)
    return march, formulas, True
