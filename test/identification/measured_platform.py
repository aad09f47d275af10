"""A platform measured without the product: springs in newtons, Runge-Kutta, Fourier sums.

Nothing here comes from qzs_rig.mechanics or qzs_rig.theory: a fit that finds the truth in these
numbers has found it in the physics, not in its own balance.
"""

from __future__ import annotations

import math

import numpy as np

K1, L20, L1, K3, M, G = 20000.0, 0.6, 0.6 * math.sqrt(3.0) / 2.0, 2000.0, 50.0, 9.80665
ACCELERATION = 4.0
STEPS = 96
"""Of a period: Runge-Kutta of fourth order is then good to 1e-6."""


def vertical_force(x, A, trim):
    """Springs less weight, N, at x m below the working point: Eq (8) times k1 L20."""
    half = math.sqrt(L20**2 - L1**2)
    length = np.sqrt(x * x + half * half)
    central, suspension = K1 * x, A * K1 * x * (1.0 - L20 / length)
    leaf = K3 * (half / length) * (x + L1)
    return central + suspension + leaf - K3 * L1 - trim * G


def stepped(hz, zeta, A, trim, settle_s, periods=4):
    """Top over base (len(hz), lanes), complex, dwelling at each of `hz` in turn for `settle_s` and
    `periods`; zeta, A and trim (kg) are (lanes,). The base moves with ACCELERATION."""
    zeta, A, trim = (np.asarray(values, float) for values in (zeta, A, trim))
    mass = M + trim
    C = 2.0 * zeta * np.sqrt(K1 * mass)
    state = np.zeros((2, len(zeta)))

    def slope(now, phase):
        w, rate = now
        force = vertical_force(w, A, trim) + C * rate
        return np.array([rate, -force / mass + ACCELERATION * math.cos(phase)])

    ratios = []
    for f in hz:
        h, turn = 1.0 / f / STEPS, 2 * math.pi / STEPS
        total = (math.ceil(settle_s * f) + periods) * STEPS
        kept = np.zeros(len(zeta), dtype=complex)
        for k in range(total):
            phase = turn * (k % STEPS)
            a = slope(state, phase)
            b = slope(state + 0.5 * h * a, phase + 0.5 * turn)
            c = slope(state + 0.5 * h * b, phase + 0.5 * turn)
            d = slope(state + h * c, phase + turn)
            if k >= total - periods * STEPS:
                kept += state[0] * np.exp(-1j * phase)
            state = state + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
        w = 2.0 * kept / (periods * STEPS)
        # w'' + … = -v'' = ACCELERATION cos φ, so v = ACCELERATION / ω² cos φ
        ratios.append(1.0 + w * (2 * math.pi * f) ** 2 / ACCELERATION)
    return np.array(ratios)
