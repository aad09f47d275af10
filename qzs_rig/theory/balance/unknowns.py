"""Harmonic balance as equations over one parameter: frequency, amplitude, damping or design."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from qzs_rig.errors import InputError
from qzs_rig.mechanics.design import Design
from qzs_rig.samples import Array
from qzs_rig.theory.balance.basis import resized
from qzs_rig.theory.balance.harmonic_balance import HarmonicBalance
from qzs_rig.theory.oscillator import Oscillator

RATIOS = ('A', 'k3', 'L1', 'L0')
PARAMETERS = ('omega', 'amplitude', 'zeta', *RATIOS)
"""What a branch can be followed over."""
_STEP = 1e-5


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
class Unknowns:
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
        """See continuation.Equations."""
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
