"""The fold of a branch, followed as the platform changes, and how it moves with parameters.

At a fold the balance R(x, Ω) = 0 has a singular slope J = ∂R/∂x. Bordered by two fixed vectors,
[J b; cᵀ 0] [v; g] = [0; 1], the number g vanishes there and J may be singular (Griewank and Reddien
1984; Kuznetsov, Elements of Applied Bifurcation Theory, section 10.2).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from qzs_rig.samples import Array
from qzs_rig.theory.balance.harmonic_balance import HarmonicBalance
from qzs_rig.theory.oscillator import Oscillator

NEWTON = 12
TOLERANCE = 1e-11
STEP = 1e-6
"""Of Ω and x, for the slope of g by differences: it only has to make Newton converge."""


@dataclass(frozen=True)
class Fold:
    """Coefficients x (2H + 1,) at `omega`."""

    omega: float
    x: Array


def fold_near(there: Oscillator, guess: Fold) -> Fold | None:
    """The fold that Newton finds from `guess`; None where it finds none near by."""
    n, balance = len(guess.x), HarmonicBalance(there, len(guess.x) // 2)
    U, _, Vt = np.linalg.svd(balance.jacobian(guess.x, guess.omega))
    y = np.append(guess.x, guess.omega)
    bordered = np.zeros((n + 2, n + 1, n + 1))
    bordered[:, :n, n], bordered[:, n, :n] = U[:, -1], Vt[-1]
    one = np.zeros(n + 1)
    one[n] = 1.0
    for _ in range(NEWTON):
        # row 0 is y itself, row k + 1 has its k-th entry moved
        ys = y + np.vstack([np.zeros(n + 1), STEP * np.eye(n + 1)])
        residual = balance.residual(ys[:, :n], ys[:, n])
        bordered[:, :n, :n] = balance.jacobian(ys[:, :n], ys[:, n])
        if not np.isfinite(bordered).all():
            return None
        g = np.linalg.solve(bordered, np.tile(one, (n + 2, 1))[..., None])[:, n, 0]
        value = np.append(residual[0], g[0])
        if np.linalg.norm(value) < TOLERANCE:
            near = abs(y[n] / guess.omega - 1.0) < 0.5
            return Fold(float(y[n]), y[:n]) if near else None
        slope = np.vstack([(residual[1:] - residual[0]).T, g[1:] - g[0]]) / STEP
        y = y - np.linalg.solve(slope, value)
        if not (np.isfinite(y).all() and y[n] > 0):
            return None
    return None


def left_null(there: Oscillator, fold: Fold) -> Array:
    """The vector ψ (2H + 1,) with ψᵀ J = 0 at `fold`."""
    jacobian = HarmonicBalance(there, len(fold.x) // 2).jacobian(fold.x, fold.omega)
    return np.asarray(np.linalg.svd(jacobian)[0][:, -1])
