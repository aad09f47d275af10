"""Laws of the literature in the words of the rig."""

from __future__ import annotations

import numpy as np

from qzs_rig.mechanics.restoring.law import PAPER_DESIGN, RestoringLaw
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import DOFS


def _forced(name, c1, zeta, push):
    law = RestoringLaw(name, 'test', lambda _: ((c1, 0.0, 1.0),) * 4, weighted=False, odd=DOFS)
    # falloff 2: the plain forced oscillator
    return Oscillator(law, 'vertical', PAPER_DESIGN, zeta, push, falloff=2)


def ueda(push=7.5):
    """x'' + 0.05 x' + x³ = push cos t (Ueda, J. Stat. Phys. 20 (1979) 181)."""
    return _forced('ueda', 0.0, 0.025, push)


def double_well(push):
    """x'' + 0.3 x' - x + x³ = push cos 1.2 t, the textbook road to chaos from x(0) = 1."""
    return _forced('double well', -1.0, 0.15, push)


def rates(oscillator, omega, phase=0.0):
    """Right-hand side for scipy."""

    def slope(t, y):
        push = oscillator.drive(omega) * np.cos(omega * t + phase)
        return [y[1], push - 2.0 * oscillator.zeta * y[1] - float(oscillator.force(y[0]))]

    return slope
