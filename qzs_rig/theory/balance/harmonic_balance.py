"""Harmonic balance of one oscillator by alternating between frequency and time (AFT), over any of
its parameters.

Cameron and Griffin, J. Appl. Mech. 56 (1989) 149; Krack and Gross, Harmonic Balance for Nonlinear
Vibration Problems (2019), sections 2.3 and 2.4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from qzs_rig.errors import InputError
from qzs_rig.mechanics.design import Design
from qzs_rig.samples import Array
from qzs_rig.theory.balance.basis import Basis, resized
from qzs_rig.theory.oscillator import Oscillator

RATIOS = ('A', 'k3', 'L1', 'L0')
PARAMETERS = ('omega', 'amplitude', 'zeta', *RATIOS)
"""What a branch can be followed over."""
VARIED = PARAMETERS[1:]
_STEP = 1e-5


@dataclass(frozen=True)
class HarmonicBalance:
    """The balance of `oscillator` in `harmonics` harmonics, vectorised over leading axes.

    Coefficients x (..., 2H + 1) are (mean, cos 1, sin 1, cos 2, sin 2, ...) of
    w(τ) = x0 + Σ x(2k-1) cos kΩτ + x(2k) sin kΩτ, the base moving as cos Ωτ. With `odd` only
    those of odd harmonics, for motions of an odd law that mirror themselves every half period.
    """

    oscillator: Oscillator
    harmonics: int
    odd: bool = False

    @cached_property
    def basis(self) -> Basis:
        """The waves of the coefficients."""
        return Basis.odd(self.harmonics) if self.odd else Basis.full(self.harmonics)

    @property
    def to_time(self) -> Array:
        """(samples, 2H + 1): coefficients to w at the samples."""
        return self.basis.to_time

    @property
    def to_frequency(self) -> Array:
        """(2H + 1, samples): values at the samples to coefficients."""
        return self.basis.to_frequency

    @property
    def _cos1(self) -> int:
        return 0 if self.odd else 1

    def linear(self, omega: ArrayLike) -> Array:
        """(..., 2H + 1, 2H + 1) of w'' + 2 ζ w' in the coefficients."""
        return linear(self.basis, self.oscillator.zeta, omega)

    def residual(self, x: Array, omega: ArrayLike) -> Array:
        """What the coefficients x (..., 2H + 1) leave unbalanced, (..., 2H + 1)."""
        frequency, own = np.asarray(omega, dtype=np.float64), self.oscillator
        rate = frequency[..., None]
        balance = own.force(x @ self.to_time.T) @ self.to_frequency.T
        balance = balance + 2 * own.zeta * rate * (x @ self.basis.derivative.T)
        balance -= (rate * self.basis.rates) ** 2 * x
        balance[..., self._cos1] -= own.drive(frequency)
        return np.asarray(balance)

    def jacobian(self, x: Array, omega: ArrayLike) -> Array:
        """Slope of `residual` in the coefficients, (..., 2H + 1, 2H + 1)."""
        return tangent(self.basis, self.oscillator, self.basis, x, omega)

    def linearised(self, x: Array, omega: float) -> tuple[Array, Array, Array]:
        """`residual`, `jacobian` and the slope of `residual` in ln Ω, all at x (2H + 1,)."""
        own, basis = self.oscillator, self.basis
        w, square = basis.to_time @ x, (omega * basis.rates) ** 2
        spin = 2 * own.zeta * omega * basis.derivative
        drag, drive = spin @ x, float(own.drive(omega))
        residual = drag - square * x + basis.to_frequency @ own.force(w)
        slope = drag - 2 * square * x
        residual[self._cos1] -= drive
        slope[self._cos1] -= (2 - own.falloff) * drive
        jacobian = basis.tangent(_spread(own.stiffness(w), w)) + spin
        jacobian.flat[:: len(x) + 1] -= square
        return residual, jacobian, slope


def linear(basis: Basis, zeta: float, omega: ArrayLike) -> Array:
    """(..., n, n) of w'' + 2 ζ w' in the n coefficients of `basis`."""
    frequency = np.asarray(omega, dtype=np.float64)[..., None, None]
    inertia = np.diag(basis.rates**2)
    return np.asarray(2 * zeta * frequency * basis.derivative - frequency**2 * inertia)


def tangent(
    basis: Basis, oscillator: Oscillator, motion: Basis, x: Array, omega: ArrayLike
) -> Array:
    """(..., n, n): what a small disturbance in `basis` of the motions x in `motion` feels."""
    w = x @ motion.to_time.T
    return linear(basis, oscillator.zeta, omega) + basis.tangent(
        _spread(oscillator.stiffness(w), w)
    )


def _spread(stiffness: Any, w: Array) -> Array:
    """A linear law's stiffness is one number."""
    return np.asarray(stiffness + np.zeros_like(w))


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


def value_of(oscillator: Oscillator, omega: float, parameter: str) -> float:
    """The present value of a parameter; InputError for one that is not in PARAMETERS."""
    if parameter not in PARAMETERS:
        raise InputError(f'unknown parameter {parameter!r}; known: {", ".join(PARAMETERS)}')
    if parameter == 'omega':
        return omega
    return float(getattr(oscillator.design if parameter in RATIOS else oscillator, parameter))


def with_value(oscillator: Oscillator, parameter: str, value: float) -> Oscillator:
    """The oscillator with another amplitude, zeta or design ratio."""
    if parameter not in RATIOS:
        changed: dict[str, Any] = {parameter: value}
        return replace(oscillator, **changed)
    ratios = {name: getattr(oscillator.design, name) for name in RATIOS}
    if parameter == 'L1' and not value < 1.0:
        raise InputError(f'L1 = {value:g} must be below 1: suspension springs would not incline')
    return replace(oscillator, design=Design.of(**{**ratios, parameter: value}))


@dataclass(frozen=True)
class BalanceEquations:
    """The coefficients of a motion in `harmonics`, or in the odd ones of them, over the logarithm
    p of `parameter`. `omega` is the frequency where that is not the parameter."""

    oscillator: Oscillator
    harmonics: int
    odd: bool = False
    parameter: str = 'omega'
    omega: float = math.nan

    @cached_property
    def balance(self) -> HarmonicBalance:
        """With the values that the oscillator came with."""
        return HarmonicBalance(self.oscillator, self.harmonics, self.odd)

    def at(self, p: float) -> tuple[Oscillator, float]:
        """The oscillator and its frequency at p."""
        value = math.exp(min(p, 50.0))
        if self.parameter == 'omega':
            return self.oscillator, value
        return with_value(self.oscillator, self.parameter, value), self.omega

    def linearised(self, x: Array, p: float) -> tuple[Array, Array, Array]:
        """See newton.Equations."""
        if self.parameter == 'omega':
            return self.balance.linearised(x, math.exp(min(p, 50.0)))
        balance, omega = self._balance(p)
        residual, jacobian, _ = balance.linearised(x, omega)
        # only Newton's pace and the tangent hang on it
        ahead, behind = (self._balance(p + side)[0].residual(x, omega) for side in (_STEP, -_STEP))
        return residual, jacobian, (ahead - behind) / (2 * _STEP)

    def full(self, x: Array) -> Array:
        """The coefficients (2H + 1,) of the unknowns x."""
        whole = np.zeros(2 * self.harmonics + 1)
        whole[self.balance.basis.columns] = x
        return whole

    def own(self, coefficients: Array) -> Array:
        """The unknowns of coefficients (2H + 1,)."""
        return resized(coefficients, self.harmonics)[self.balance.basis.columns]

    def _balance(self, p: float) -> tuple[HarmonicBalance, float]:
        oscillator, omega = self.at(p)
        return HarmonicBalance(oscillator, self.harmonics, self.odd), omega
