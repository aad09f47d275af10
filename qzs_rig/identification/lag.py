"""What a sweep shows of a curve: behind the steady motion, to first order in the sweep rate.

The motion Re Σ X_k(τ) exp(ikφ), φ' = Ω(τ), balances as in the steady state plus, in harmonic k,

    (2ikΩ + 2ζ) X_k' + ikΩ' X_k,       X' = dX/dΩ · Ω',

and the base V exp(iφ), V = Ĥ Ω^-falloff, accelerates by -V (Ω² - i(1 - 2 falloff) Ω'). The second
derivative and the products of Ω' that are left out make it good while the correction is small.
"""

from __future__ import annotations

import numpy as np

from qzs_rig.identification.points import Complex
from qzs_rig.samples import Array
from qzs_rig.theory.balance.harmonic_balance import HarmonicBalance, transmissibility
from qzs_rig.theory.oscillator import Oscillator


def swept_over_steady(plant: Oscillator, omega: Array, rate: Array, x: Array) -> Complex:
    """Ratio (n,) of u/v as swept through `omega` (n,) at dΩ/dτ = `rate` (n,) to u/v settled at
    coefficients x (n, 2H + 1)."""
    H, falloff = x.shape[1] // 2, plant.falloff
    balance, h = HarmonicBalance(plant, H), 1e-5 * omega
    jacobian = balance.jacobian(x, omega)
    slope = (balance.residual(x, omega + h) - balance.residual(x, omega - h)) / (2 * h)[:, None]
    dx = -np.linalg.solve(jacobian, slope[..., None])[..., 0] * rate[:, None]
    k = np.arange(1, H + 1)
    X, dX = _complex(x), _complex(dx)
    turning = 1j * k * omega[:, None]
    unbalanced = (2 * turning + 2 * plant.zeta) * dX + 1j * k * rate[:, None] * X
    V = plant.base(omega)
    unbalanced[:, 0] += 1j * (1 - 2 * falloff) * rate * V
    missing = np.empty_like(x)
    missing[:, 0] = 2 * plant.zeta * dx[:, 0]
    missing[:, 1::2], missing[:, 2::2] = unbalanced.real, -unbalanced.imag
    late = _complex(x - np.linalg.solve(jacobian, missing[..., None])[..., 0])[:, 0]
    acceleration = (1j * rate - omega**2) * late + 2j * omega * dX[:, 0]
    base = -(omega**2 - 1j * (1 - 2 * falloff) * rate) * V
    return np.asarray((1.0 + acceleration / base) / transmissibility(plant, omega, x))


def iso_limit(half_power_hz: float) -> float:
    """Fastest linear sweep by ISO 7626-2 in Hz/s: 54 f²/Q² Hz a minute, f/Q the half-power
    bandwidth; through a softer or stiffer branch the bandwidth 2ζ f0 stays."""
    return 0.9 * half_power_hz**2


def _complex(x: Array) -> Complex:
    return np.asarray(x[:, 1::2] - 1j * x[:, 2::2])
