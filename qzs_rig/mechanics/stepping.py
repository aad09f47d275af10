"""From base samples to top samples: what every integrator of a platform does alike."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from qzs_rig.errors import DivergenceError, InputError
from qzs_rig.samples import Array


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
