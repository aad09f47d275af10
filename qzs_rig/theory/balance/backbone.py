"""Free motions of the undamped platform, and what drives the damped one through them.

For one degree of freedom the extended periodic motion concept (Krack, Comput. Struct. 154 (2015)
59) is the conservative backbone itself: its artificial negative damping cancels 2 ζ w' exactly, and
the damping ratio of the mode at Ω is ζ/Ω. The damped curve here is that of phase resonance: forced
motions, all harmonics, whose fundamental lags the drive by 90 degrees, with the drive it takes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from qzs_rig.samples import Array
from qzs_rig.theory.balance import continuation, newton
from qzs_rig.theory.balance.basis import resized
from qzs_rig.theory.balance.continuation import Ending, Steps, Stop, WholePath
from qzs_rig.theory.balance.harmonic_balance import HarmonicBalance
from qzs_rig.theory.balance.newton import Point, one_thread
from qzs_rig.theory.balance.search import describing
from qzs_rig.theory.oscillator import Oscillator

HARMONICS = 31


@dataclass(frozen=True)
class Backbone:
    """Motions `coefficients` (n, 2H + 1) at `omega` (n,), `amplitude` (n,) of the fundamental.

    `damping_ratio` (n,) is the mode's, `drive_hat` (n,) the base amplitude Ĥ at Ω = 1 (falling as
    the oscillator's falloff) that holds the damped motion in resonance.
    """

    omega: Array
    amplitude: Array
    damping_ratio: Array
    drive_hat: Array
    coefficients: Array
    ends: tuple[Ending, Ending]


@dataclass(frozen=True)
class Free:
    """Undamped, undriven, even in time: the unknowns are mean and cosines, over ln Ω."""

    balance: HarmonicBalance

    @property
    def rows(self) -> NDArray[np.int64]:
        """Places of mean and cosines."""
        return np.append(0, np.arange(1, 2 * self.balance.harmonics, 2))

    def linearised(self, x: Array, p: float) -> tuple[Array, Array, Array]:
        """See newton.Equations."""
        residual, jacobian, slope = self.balance.slopes(self.full(x), math.exp(min(p, 50.0)))
        return residual[self.rows], jacobian[np.ix_(self.rows, self.rows)], slope[self.rows]

    def full(self, x: Array) -> Array:
        """Coefficients (2H + 1,)."""
        whole = np.zeros(2 * self.balance.harmonics + 1)
        whole[self.rows] = x
        return whole


@dataclass(frozen=True)
class Resonant:
    """Driven, with no cosine in the fundamental; its place among the unknowns has the drive."""

    balance: HarmonicBalance

    def linearised(self, x: Array, p: float) -> tuple[Array, Array, Array]:
        """See newton.Equations."""
        motion = self.full(x)
        residual, jacobian, slope = self.balance.slopes(motion, math.exp(min(p, 50.0)))
        residual[1] -= x[1]
        jacobian[:, 1] = 0.0
        jacobian[1, 1] = -1.0
        return residual, jacobian, slope

    def full(self, x: Array) -> Array:
        """Coefficients (2H + 1,)."""
        whole = np.array(x)
        whole[1] = 0.0
        return whole


@one_thread
def backbone(
    oscillator: Oscillator, low: float, high: float, amplitude: tuple[float, float] = (1e-3, 3.0)
) -> tuple[Backbone, ...]:
    """Conservative backbones within Ω in [low, high] and fundamentals in `amplitude`.

    One for each equilibrium that motions of middle amplitude swing about.
    """
    free = replace(oscillator, zeta=0.0, amplitude=0.0)
    equations = Free(HarmonicBalance(free, HARMONICS))
    table, found = describing(replace(oscillator, zeta=0.0)), []
    middle = math.sqrt(amplitude[0] * amplitude[1])
    for family in np.unique(table.family):
        own = (table.family == family) & (table.N > 0)
        near = own & (np.sqrt(np.where(own, table.N, 1.0)) > low)
        near &= np.sqrt(np.where(own, table.N, 1.0)) < high
        if not near.any():
            continue
        k = np.flatnonzero(near)[np.argmin(np.abs(np.log(table.W[near] / middle)))]
        start = resized(np.array([table.m[k], table.W[k], 0.0]), HARMONICS)[equations.rows]
        plane = np.zeros(len(start) + 1)
        plane[1] = 1.0
        size = float(np.linalg.norm(start))
        at = newton.correct(equations, start, 0.5 * math.log(table.N[k]), plane, size, 1e-10)
        if at is not None:
            path = _followed(equations, at[0], (low, high), amplitude, 1)
            found.append(_backbone(oscillator, equations, path))
    return tuple(found)


def phase_resonance(oscillator: Oscillator, curve: Backbone) -> Backbone | None:
    """The damped curve beside a backbone, over the same frequencies; None where its middle leads
    nowhere (damping so strong that no motion lags by 90 degrees)."""
    equations = Resonant(HarmonicBalance(replace(oscillator, amplitude=0.0), HARMONICS))
    k = len(curve.omega) // 2
    omega, x = float(curve.omega[k]), _delayed(curve.coefficients[k])
    # power in = power lost, for the fundamental alone
    x[1] = 2 * oscillator.zeta * omega * x[2]
    bounds = float(curve.omega.min()) * (1 - 1e-3), float(curve.omega.max()) * (1 + 1e-3)
    reach = float(curve.amplitude.min()), float(curve.amplitude.max())
    # at a given amplitude: a linear law resonates at one frequency only
    plane = np.zeros(len(x) + 1)
    plane[2] = 1.0
    size = float(np.linalg.norm(x))
    start = newton.correct(equations, x, math.log(omega), plane, size, 1e-10)
    if start is None:
        return None
    path = _followed(equations, start[0], bounds, reach, 2)
    found = _backbone(oscillator, equations, path)
    drive = np.array([abs(q.x[1]) for q in path.points])
    return replace(found, drive_hat=drive / found.omega ** (2 - oscillator.falloff))


def _followed(
    equations: Free | Resonant,
    start: Point,
    omega: tuple[float, float],
    amplitude: tuple[float, float],
    fundamental: int,
) -> WholePath:
    def stop_check(_: Point, point: Point) -> Ending | None:
        W = abs(float(point.x[fundamental]))
        if equations.balance.oscillator.domain < W:
            return Ending(
                Stop.DOMAIN, f'the law ends at |w| = {equations.balance.oscillator.domain:g}'
            )
        return None if amplitude[0] <= W <= amplitude[1] else Ending(Stop.AMPLITUDE)

    low, high = math.log(omega[0]), math.log(omega[1])
    return continuation.both_ways(
        equations, start.x, start.p, low, high, stop_check, Steps(largest=0.06)
    )


def _backbone(oscillator: Oscillator, equations: Free | Resonant, path: WholePath) -> Backbone:
    omega = np.exp([q.p for q in path.points])
    x = np.array([equations.full(q.x) for q in path.points])
    W = np.hypot(x[:, 1], x[:, 2])
    drive = 2 * oscillator.zeta * omega * _lost(x)
    return Backbone(
        omega,
        W,
        oscillator.zeta / omega,
        drive / omega ** (2 - oscillator.falloff),
        x,
        path.ends,
    )


def _lost(x: Array) -> Array:
    """Energy that damping takes over what a unit drive gives: Σ k² w_k² / w_1."""
    squares = (np.arange(1, x.shape[1] // 2 + 1) ** 2) * (x[:, 1::2] ** 2 + x[:, 2::2] ** 2)
    return np.asarray(squares.sum(axis=1) / np.hypot(x[:, 1], x[:, 2]))


def _delayed(x: Array) -> Array:
    """The motion (2H + 1,) a quarter of a period later: cos becomes sin."""
    turned = np.array(x)
    order = np.arange(1, len(x) // 2 + 1)
    w = (x[1::2] - 1j * x[2::2]) * np.exp(-0.5j * np.pi * order)
    turned[1::2], turned[2::2] = w.real, -w.imag
    return turned
