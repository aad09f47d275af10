"""Oscillators and their integrated motion: the independent reference of the theory tests."""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp

from qzs_rig.mechanics.restoring.law import PAPER_DESIGN, RestoringLaw
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import DOFS


def cubic(c1, c3):
    """x'' + ... + c1 x + c3 x³, in every degree of freedom."""
    return RestoringLaw('cubic', 'test', lambda _: ((c1, 0.0, c3),) * 4, weighted=False, odd=DOFS)


DUFFING = Oscillator(cubic(1.0, 0.1), 'vertical', PAPER_DESIGN, 0.025, 0.18, falloff=2)
"""x'' + 0.05 x' + x + 0.1 x³ = 0.18 cos Ωt: example 01 of NLvib (Krack and Gross 2019)."""


def state(coefficients, omega):
    """(w, w') of a motion (2H + 1,) at τ = 0."""
    order = np.arange(1, len(coefficients) // 2 + 1)
    w = coefficients[0] + coefficients[1::2].sum()
    return np.array([w, omega * (order * coefficients[2::2]).sum()])


def integrated(oscillator, omega, start, periods=1.0):
    """(w, w') (2, 2, 2...) after so many periods of the drive, with the flow's slope in `start`."""
    drive, zeta = float(oscillator.drive(omega)), oscillator.zeta
    force = oscillator.law.along(oscillator.number, math.sqrt)
    slope = oscillator.law.stiffness_along(oscillator.number)
    design, load = oscillator.design, oscillator.load

    def rate(t, y):
        k = slope(design, y[0])
        pull = drive * math.cos(omega * t) - 2 * zeta * y[1] - force(design, y[0]) + load
        return (
            *(y[1], pull),
            *(y[3], -2 * zeta * y[3] - k * y[2]),
            *(y[5], -2 * zeta * y[5] - k * y[4]),
        )

    y0 = [*start, 1.0, 0.0, 0.0, 1.0]
    end = periods * 2 * np.pi / omega
    y = solve_ivp(rate, (0.0, end), y0, 'DOP853', [end], rtol=1e-11, atol=1e-13).y[:, -1]
    return y[:2], np.array([[y[2], y[4]], [y[3], y[5]]])
