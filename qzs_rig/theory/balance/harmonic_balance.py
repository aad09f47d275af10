"""Harmonic balance of one oscillator by alternating between frequency and time (AFT), over any of
its parameters.

Cameron and Griffin, J. Appl. Mech. 56 (1989) 149; Krack and Gross, Harmonic Balance for Nonlinear
Vibration Problems (2019), sections 2.3 and 2.4.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from qzs_rig.errors import InputError
from qzs_rig.samples import Array
from qzs_rig.theory.balance.basis import Basis, harmonics_of, resized, symmetric
from qzs_rig.theory.balance.continuation import Ending, Steps, Stop
from qzs_rig.theory.balance.newton import Point, length_of
from qzs_rig.theory.balance.stability import (
    Stability,
    changes,
    determinants,
    floquet,
    stiffness,
    tangent,
)
from qzs_rig.theory.oscillator import Oscillator

RATIOS = ('A', 'k3', 'L1', 'L0')
PARAMETERS = ('omega', 'amplitude', 'zeta', *RATIOS)
"""What a branch can be followed over."""
VARIED = PARAMETERS[1:]
FURTHEST = 1e3
"""Motion in L20 or rad, over max(1, Ĥ), at which a branch counts as unbounded."""
_STEP = 1e-5


@dataclass(frozen=True)
class HarmonicBalance:
    """The balance of `oscillator` in `harmonics` harmonics; see branch.Balance.

    Coefficients (..., 2H + 1) are (mean, cos 1, sin 1, cos 2, sin 2, ...) of
    w(τ) = x0 + Σ x(2k-1) cos kΩτ + x(2k) sin kΩτ, the base moving as cos Ωτ. The unknowns x are all
    of them or, with `odd`, those of odd harmonics, for motions of an odd law that mirror themselves
    every half period. A branch is followed over the logarithm p of `parameter`; `omega` is the
    frequency where that is another.
    """

    oscillator: Oscillator
    harmonics: int
    odd: bool = False
    parameter: str = 'omega'
    omega: float = math.nan

    ladder: ClassVar[tuple[int, ...]] = (7, 11, 15, 21, 29, 41, 57, 79, 111, 155)
    accuracy: ClassVar[float] = 1e-8
    loosest: ClassVar[float] = 1e-8
    steps: ClassVar[Steps] = Steps(most=1500)
    finest: ClassVar[int] = 160
    by_determinant: ClassVar[bool] = True

    @cached_property
    def basis(self) -> Basis:
        """The waves of the unknowns."""
        return Basis.odd(self.harmonics) if self.odd else Basis.full(self.harmonics)

    @cached_property
    def mirrored(self) -> bool:
        """Is a motion, upside down and half a period later, a motion, too?"""
        return not self.odd and symmetric(self.oscillator)

    @property
    def _cos1(self) -> int:
        return 0 if self.odd else 1

    def residual(self, x: Array, omega: ArrayLike) -> Array:
        """What the unknowns x (..., n) leave unbalanced at `omega` (...,), (..., n)."""
        frequency, own = np.asarray(omega, dtype=np.float64), self.oscillator
        rate = frequency[..., None]
        balance = own.force(x @ self.basis.to_time.T) @ self.basis.to_frequency.T
        balance = balance + 2 * own.zeta * rate * (x @ self.basis.derivative.T)
        balance -= (rate * self.basis.rates) ** 2 * x
        balance[..., self._cos1] -= own.drive(frequency)
        return np.asarray(balance)

    def jacobian(self, x: Array, omega: ArrayLike) -> Array:
        """Slope of `residual` in the unknowns, (..., n, n)."""
        return tangent(self.basis, self.oscillator, self.basis, x, omega)

    def slopes(self, x: Array, omega: float) -> tuple[Array, Array, Array]:
        """`residual`, `jacobian` and the slope of `residual` in ln Ω, all at x (n,)."""
        own, basis = self.oscillator, self.basis
        w, square = basis.to_time @ x, (omega * basis.rates) ** 2
        spin = 2 * own.zeta * omega * basis.derivative
        drag, drive = spin @ x, float(own.drive(omega))
        residual = drag - square * x + basis.to_frequency @ own.force(w)
        slope = drag - 2 * square * x
        residual[self._cos1] -= drive
        slope[self._cos1] -= (2 - own.falloff) * drive
        jacobian = basis.tangent(stiffness(own, w)) + spin
        jacobian.flat[:: len(x) + 1] -= square
        return residual, jacobian, slope

    def at(self, p: float) -> tuple[Oscillator, float]:
        """The oscillator and its frequency at p."""
        value = math.exp(min(p, 50.0))
        if self.parameter == 'omega':
            return self.oscillator, value
        return with_value(self.oscillator, self.parameter, value), self.omega

    def linearised(self, x: Array, p: float) -> tuple[Array, Array, Array]:
        """See newton.Equations."""
        own, omega = self.at(p)
        if self.parameter == 'omega':
            return self.slopes(x, omega)
        residual, jacobian, _ = replace(self, oscillator=own).slopes(x, omega)
        # only Newton's pace and the tangent hang on it
        ahead, behind = (
            replace(self, oscillator=self.at(p + side)[0]).residual(x, omega)
            for side in (_STEP, -_STEP)
        )
        return residual, jacobian, (ahead - behind) / (2 * _STEP)

    def full(self, x: Array) -> Array:
        """The coefficients (2H + 1,) of the unknowns x."""
        whole = np.zeros(2 * self.harmonics + 1)
        whole[self.basis.columns] = x
        return whole

    def own(self, coefficients: Array) -> Array:
        """The unknowns of coefficients in any number of harmonics."""
        return resized(coefficients, self.harmonics)[self.basis.columns]

    def tail(self, coefficients: Array, harmonics: int) -> float:
        """What the last two of `harmonics`, and all above, are of the whole."""
        return length_of(coefficients[2 * harmonics - 3 :]) / (length_of(coefficients) or 1.0)

    def beyond(self, x: Array) -> Ending | None:
        """Why the equations end at unknowns x (n,), the law's domain or all bounds; None inside."""
        own, w = self.oscillator, float(np.abs(self.basis.to_time @ x).max())
        if w >= 0.9999 * own.domain:
            return Ending(Stop.DOMAIN, f'law {own.law.name} ends at |w| = {own.domain:g}')
        if w > FURTHEST * max(1.0, own.amplitude):
            return Ending(Stop.UNBOUNDED, f'the motion grows beyond {w:.3g}')
        return None

    def relative(self, values: Array, coefficients: Array) -> Array:
        """The coefficients (n, 2H + 1) as they are."""
        return coefficients

    def frequency(self, values: Array) -> Array:
        """Ω (n,) at `values` of the parameter."""
        return values if self.parameter == 'omega' else np.full(len(values), self.omega)

    def base(self, values: Array) -> Array:
        """Amplitude (n,) of the base at `values` of the parameter."""
        return np.concatenate([own.base(omega) for own, omega, _ in self._pieces(values)])

    def stability(self, values: Array, coefficients: Array) -> Stability:
        """Of motions (n, 2H + 1) at `values` (n,) of the parameter."""
        found = [
            floquet(own, omega, coefficients[part], self.odd)
            for own, omega, part in self._pieces(values)
        ]
        other = np.concatenate([piece.other for piece in found])
        return Stability(
            np.concatenate([piece.multipliers for piece in found]),
            np.concatenate([piece.stable for piece in found]),
            changes(other > 0),
        )

    def defect(self, values: Array, coefficients: Array) -> float:
        """The most that any of the motions leaves unbalanced in twice the harmonics, over the
        drive."""
        harmonics = 2 * harmonics_of(coefficients)
        x, worst = resized(coefficients, harmonics), 0.0
        for own, omega, part in self._pieces(values):
            left = HarmonicBalance(own, harmonics).residual(x[part], omega)
            worst = max(worst, float((np.linalg.norm(left, axis=1) / own.drive(omega)).max()))
        return worst

    def _pieces(self, values: Array) -> Iterator[tuple[Oscillator, Array, slice]]:
        """Motions of one oscillator together: it, their frequencies and their places."""
        if self.parameter == 'omega':
            yield self.oscillator, values, slice(None)
            return
        for k, value in enumerate(values.tolist()):
            own = with_value(self.oscillator, self.parameter, value)
            yield own, np.array([self.omega]), slice(k, k + 1)

    def losing(self, point: Point) -> float:
        """0 where a motion loses its stability other than by a fold."""
        oscillator, omega = self.at(point.p)
        return determinants(oscillator, omega, self.full(point.x), self.odd)[1]

    def kind(self, point: Point) -> str:
        """The kind of that event: 'symmetry_breaking' of odd motions, else 'period_doubling'."""
        return 'symmetry_breaking' if self.odd else 'period_doubling'

    def along(self, point: Point) -> tuple[complex, complex]:
        """u/v of the fundamentals, and its slope along a path over frequency."""
        oscillator, omega = self.at(point.p)
        x, step = self.full(point.x), point.size * self.full(point.tangent[:-1])
        base, rise = float(oscillator.base(omega)), float(point.tangent[-1])
        w, move = complex(x[1], -x[2]) / base, complex(step[1], -step[2]) / base
        return 1.0 + w, move + oscillator.falloff * rise * w


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
    """Newton from `start` (n, 2H + 1) at fixed frequencies `omega` (n,), all at once, where
    scipy.optimize.root takes one after the other.

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
    if parameter == 'L1' and not value < 1.0:
        raise InputError(f'L1 = {value:g} must be below 1: suspension springs would not incline')
    return replace(oscillator, design=oscillator.design.replace(**{parameter: value}))
