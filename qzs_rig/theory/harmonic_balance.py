"""Harmonic balance of one oscillator by alternating between frequency and time (AFT).

Cameron and Griffin, J. Appl. Mech. 56 (1989) 149; Krack and Gross, Harmonic Balance for Nonlinear
Vibration Problems (2019), sections 2.3 and 2.4.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.timehistory import Array


@dataclass(frozen=True)
class HarmonicBalance:
    """The balance of `oscillator` in `harmonics` harmonics, vectorised over leading axes.

    Coefficients x (..., 2H + 1) are (mean, cos 1, sin 1, cos 2, sin 2, ...) of
    w(τ) = x0 + Σ x(2k-1) cos kΩτ + x(2k) sin kΩτ, the base moving as cos Ωτ.
    """

    oscillator: Oscillator
    harmonics: int

    @cached_property
    def samples(self) -> int:
        """Times a period at which the force is evaluated: products up to third order are exact."""
        return max(16, 1 << int(np.ceil(np.log2(4 * self.harmonics + 1))))

    @cached_property
    def to_time(self) -> Array:
        """(samples, 2H + 1): coefficients to w at the samples."""
        angle = 2 * np.pi * np.outer(np.arange(self.samples), self._orders) / self.samples
        wave = np.stack([np.cos(angle), np.sin(angle)], axis=-1).reshape(self.samples, -1)
        return np.concatenate([np.ones((self.samples, 1)), wave], axis=1)

    @cached_property
    def to_frequency(self) -> Array:
        """(2H + 1, samples): values at the samples to coefficients."""
        back = 2.0 * self.to_time.T / self.samples
        back[0] *= 0.5
        return np.asarray(back)

    @property
    def _orders(self) -> NDArray[np.int64]:
        return np.arange(1, self.harmonics + 1)

    def linear(self, omega: ArrayLike) -> Array:
        """(..., 2H + 1, 2H + 1) of w'' + 2 ζ w' in the coefficients."""
        rate = np.asarray(omega, dtype=np.float64)[..., None] * self._orders
        matrix = np.zeros((*rate.shape[:-1], 2 * self.harmonics + 1, 2 * self.harmonics + 1))
        cos, sin = 2 * self._orders - 1, 2 * self._orders
        matrix[..., cos, cos] = matrix[..., sin, sin] = -(rate**2)
        matrix[..., cos, sin] = 2 * self.oscillator.zeta * rate
        matrix[..., sin, cos] = -2 * self.oscillator.zeta * rate
        return matrix

    def residual(self, x: Array, omega: ArrayLike) -> Array:
        """What the coefficients x (..., 2H + 1) leave unbalanced, (..., 2H + 1)."""
        force = self.oscillator.force(x @ self.to_time.T) @ self.to_frequency.T
        balance = (self.linear(omega) @ x[..., None])[..., 0] + force
        balance[..., 1] -= self.oscillator.drive(np.asarray(omega, dtype=np.float64))
        return np.asarray(balance)

    def jacobian(self, x: Array, omega: ArrayLike) -> Array:
        """Slope of `residual` in the coefficients, (..., 2H + 1, 2H + 1)."""
        stiffness = self.oscillator.stiffness(x @ self.to_time.T)
        tangent = (self.to_frequency * stiffness[..., None, :]) @ self.to_time
        return np.asarray(self.linear(omega) + tangent)


@dataclass(frozen=True)
class Steady:
    """Periodic motions: `coefficients` (n, 2H + 1) at `omega` (n,), and which `converged` (n,)."""

    omega: Array
    coefficients: Array
    converged: NDArray[np.bool_]


def steady(
    oscillator: Oscillator,
    omega: ArrayLike,
    start: Array,
    tolerance: float = 1e-12,
    iterations: int = 20,
) -> Steady:
    """Newton from `start` (n, 2H + 1) at fixed frequencies `omega` (n,), all at once.

    A motion that does not converge, or leaves the law's domain, keeps its last iterate and says so.
    """
    frequency = np.atleast_1d(np.asarray(omega, dtype=np.float64))
    x = np.array(np.broadcast_to(start, (len(frequency), np.shape(start)[-1])), dtype=np.float64)
    balance = HarmonicBalance(oscillator, x.shape[-1] // 2)
    done = np.zeros(len(frequency), dtype=bool)
    left = np.arange(len(frequency))
    for _ in range(iterations):
        with np.errstate(all='ignore'):
            residual = balance.residual(x[left], frequency[left])
            good = np.linalg.norm(residual, axis=-1) <= tolerance
            done[left[good]] = True
            left, residual = left[~good], residual[~good]
            jacobian = balance.jacobian(x[left], frequency[left])
        solvable = np.isfinite(jacobian).all(axis=(1, 2)) & np.isfinite(residual).all(axis=1)
        left, jacobian, residual = left[solvable], jacobian[solvable], residual[solvable]
        if not left.size:
            break
        x[left] -= np.linalg.solve(jacobian, residual[..., None])[..., 0]
    return Steady(frequency, x, done)


def transmissibility(
    oscillator: Oscillator, omega: Array, coefficients: Array
) -> NDArray[np.complex128]:
    """u/v of the fundamentals (n,), complex: its angle is the phase of the top against the base."""
    w = coefficients[..., 1] - 1j * coefficients[..., 2]
    return np.asarray(1.0 + w / oscillator.base(omega))
