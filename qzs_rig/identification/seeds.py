"""From a measured transmissibility to the relative motion it implies, before any law is known."""

from __future__ import annotations

import numpy as np

from qzs_rig.identification.points import Complex, Points
from qzs_rig.samples import Array
from qzs_rig.theory.balance.harmonic_balance import HarmonicBalance
from qzs_rig.theory.oscillator import Oscillator

WELL = 0.15
"""In units of L20; wells of A = 1.12 lie 0.07 from the middle."""


def ratios(plant: Oscillator, points: Points) -> tuple[Complex, ...]:
    """u/v of the points (n,), one candidate or two.

    With phases it is what was measured. Without one the power that the damping takes fixes
    it: with m = |w/v|², the base does 2ζΩ m of work for -Ω² Im(w/v), and T² = |1 + w/v|² leaves a
    quadratic in m: the plate moves with the base (smaller m) or against it.
    """
    spoken = points.magnitude * np.exp(1j * np.nan_to_num(points.phase))
    if points.phased.all():
        return (spoken,)
    omega, T = plant.omega(points.frequency_hz), points.magnitude
    c, D = T**2 - 1.0, 2.0 * plant.zeta / omega
    root = np.sqrt(np.maximum(T**2 - (D * c) ** 2, 0.0))
    lean = 0.5 * c + 1.0
    found = []
    for side in (-1.0, 1.0):
        m = np.maximum((lean + side * root) / (0.5 + 2.0 * D**2), 0.0)
        silent = 1.0 + 0.5 * (c - m) - 1j * D * m
        found.append(np.where(points.phased, spoken, silent))
    return tuple(found)


def centred(plant: Oscillator, omega: Array, ratio: Complex) -> list[Array]:
    """Motions (n, 3) that show u/v = `ratio` (n,), each about a mean that balances them.

    A platform with A beyond the QZS condition has a well on either side: the mean is looked for
    from where it rests and from either side of that, WELL away.
    """
    found = []
    for side in (0.0, -WELL, WELL):
        x = motion_of(plant, omega, ratio, 1)
        x[:, 0] += side
        found.append(_balanced(plant, omega, x))
    return found


def motion_of(own: Oscillator, omega: Array, ratio: Complex, harmonics: int) -> Array:
    """Coefficients (n, 2H + 1) that show u/v = `ratio` (n,) about the position of rest."""
    w = (ratio - 1.0) * own.base(omega)
    x = np.zeros((len(w), 2 * harmonics + 1))
    x[:, 0], x[:, 1], x[:, 2] = own.rest, w.real, -w.imag
    return x


def _balanced(plant: Oscillator, omega: Array, x: Array) -> Array:
    """x (n, 3) with the mean that balances its fundamental, by Newton with bounded steps."""
    balance = HarmonicBalance(plant, 1)
    for _ in range(8):
        force = balance.residual(x, omega)[:, 0]
        stiffness = balance.jacobian(x, omega)[:, 0, 0]
        step = -force / np.maximum(stiffness, 1e-3)
        x[:, 0] += np.clip(step, -0.1, 0.1)
    return x
