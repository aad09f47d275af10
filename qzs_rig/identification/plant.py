"""One degree of freedom of a run as the balance sees it, in nondimensional frequency."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import InputError
from qzs_rig.excitation import QUANTITIES
from qzs_rig.mechanics.platform import Platform
from qzs_rig.parameters import RunSpec
from qzs_rig.samples import Array
from qzs_rig.theory.balance.harmonic_balance import HarmonicBalance
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import DOFS

Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Plant:
    """The oscillator with its reference frequency `omega0` in rad/s; `rest` is where it rests."""

    oscillator: Oscillator
    omega0: float
    rest: float

    def omega(self, frequency_hz: Array) -> Array:
        """Hz to Ω."""
        return np.asarray(2 * np.pi * frequency_hz / self.omega0)

    def rate(self, chirp: Array) -> Array:
        """Hz/s to dΩ/dτ."""
        return np.asarray(2 * np.pi * chirp / self.omega0**2)

    def balance(self, harmonics: int) -> HarmonicBalance:
        """Its harmonic balance."""
        return HarmonicBalance(self.oscillator, harmonics)

    def top_over_base(self, omega: Array, x: Array) -> Complex:
        """u/v of the fundamentals (n,) at coefficients x (n, 2H + 1)."""
        return np.asarray(1.0 + (x[:, 1] - 1j * x[:, 2]) / self.oscillator.base(omega))

    def motion(self, omega: Array, ratio: Complex, harmonics: int) -> Array:
        """Coefficients (n, 2H + 1) that show u/v = `ratio` (n,) about the position of rest."""
        w = (ratio - 1.0) * self.oscillator.base(omega)
        x = np.zeros((len(w), 2 * harmonics + 1))
        x[:, 0], x[:, 1], x[:, 2] = self.rest, w.real, -w.imag
        return x


def plant(spec: RunSpec, dof: str) -> Plant:
    """`dof` of the platform of `spec` under its excitation.

    Raises InputError where the base does not move in `dof`: how far it moves decides the curve.
    """
    amplitude = spec.number(f'excitation.amplitude.{dof}')
    if not amplitude:
        raise InputError(
            f'excitation.amplitude.{dof} is 0, but {dof} was measured: say how the base moved, '
            f'for instance --set excitation.quantity=acceleration --set '
            f'excitation.amplitude.{dof}=4.0'
        )
    platform, k = Platform.from_spec(spec), DOFS.index(dof)
    falloff = QUANTITIES.index(spec.text('excitation.quantity'))
    omega0 = platform.omega0[k]
    hat = amplitude / omega0**falloff / abs(platform.length[k])
    if not (platform.zeta[k] > 0 and math.isfinite(hat)):
        raise InputError(f'{dof} has no damping to start from; give --set platform.zeta=0.02 or so')
    oscillator = Oscillator(
        platform.law, dof, platform.design, platform.zeta[k], hat, platform.load[k], falloff
    )
    return Plant(oscillator, omega0, platform.rest[k])
