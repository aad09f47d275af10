"""Steady response at the measured points: on which branch, and how it moves with the parameters."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from qzs_rig.identification.points import Complex, Points
from qzs_rig.identification.seeds import centred, ratios
from qzs_rig.identification.unknowns import Unknowns
from qzs_rig.samples import Array
from qzs_rig.theory.balance.harmonic_balance import HarmonicBalance, steady, transmissibility
from qzs_rig.theory.oscillator import Oscillator

STEP = 1e-5
"""Of a parameter's scale, for central differences of the balance at fixed motion: truncation
(1e-10) and rounding (1e-11) then weigh about the same, as the balance is smooth and of order 1."""
EDGE = 0.003
"""Relative distance to the end of a branch below which a point is left out: there T moves like a
square root, and neither a linear interval nor the measured frequency is good enough."""
OFF = 0.7
"""|ln T| by which a branch may miss a point and still be the one it lies on: a factor of two."""


@dataclass(frozen=True)
class Response:
    """Steady motions at the points of one degree of freedom.

    `x` (n, 2H + 1) are the coefficients, `ratio` (n,) u/v; `good` says where a stable motion was
    found. Where not, x is where the search began.
    """

    plant: Oscillator
    omega: Array
    x: Array
    ratio: Complex
    good: NDArray[np.bool_]

    @property
    def upper(self) -> NDArray[np.bool_]:
        """Points on the branch that lies before its resonance: base and relative motion go the
        same way, the plate's spring still outweighs its inertia."""
        return np.asarray((self.ratio - 1.0).real > 0)


def followed(there: Oscillator, frequency_hz: Array, x: Array) -> Response:
    """The motions that Newton finds from x (n, 2H + 1); unstable ones are not good."""
    omega = there.omega(frequency_hz)
    found = steady(there, omega, x)
    good = found.converged & np.isfinite(found.coefficients).all(axis=1)
    motion = np.where(good[:, None], found.coefficients, x)
    determinant = np.linalg.det(HarmonicBalance(there, x.shape[1] // 2).jacobian(motion, omega))
    # the middle branch between two folds has one growing exponent: the determinant changes sign
    return Response(
        there, omega, motion, transmissibility(there, omega, motion), good & (determinant > 0)
    )


def nearest(there: Oscillator, points: Points, harmonics: int) -> Response:
    """The stable motion nearest to each point, from the motion that its transmissibility implies.

    A branch that misses a point by more than a factor of two is not good for it.
    """
    omega = there.omega(points.frequency_hz)
    best: Response | None = None
    motions = [m for ratio in ratios(there, points) for m in centred(there, omega, ratio)]
    for motion in motions:
        x = np.zeros((len(points), 2 * harmonics + 1))
        x[:, :3] = motion
        answer = followed(there, points.frequency_hz, x)
        best = answer if best is None else _better(best, answer, points)
    assert best is not None
    return replace(best, good=best.good & (_miss(best, points) < OFF))


def _better(one: Response, other: Response, points: Points) -> Response:
    """At each point the response that misses it by less."""
    swap = _miss(other, points) < _miss(one, points)
    return replace(
        one,
        x=np.where(swap[:, None], other.x, one.x),
        ratio=np.where(swap, other.ratio, one.ratio),
        good=np.where(swap, other.good, one.good),
    )


def ends_near(response: Response, frequency_hz: Array) -> NDArray[np.bool_]:
    """Points (n,) whose branch ends, or turns by half, within EDGE of their frequency."""
    ends = np.zeros(len(frequency_hz), dtype=bool)
    for side in (1.0 - EDGE, 1.0 + EDGE):
        beside = followed(response.plant, side * frequency_hz, response.x)
        with np.errstate(divide='ignore', invalid='ignore'):
            turned = np.abs(np.log(np.abs(beside.ratio / response.ratio))) > 0.5
        ends |= ~beside.good | turned
    return ends


def sensitivity(
    unknowns: Unknowns, values: Array, dof: str, response: Response, hz: Array
) -> Complex:
    """Slope of ln(u/v) in the parameters (n, p) at `values`, by implicit differentiation: the
    balance R(x, p) = 0 moves x by -J⁻¹ ∂R/∂p."""
    x, harmonics = response.x, response.x.shape[1] // 2
    n, p = len(x), len(values)
    residual, ratio = np.empty((p, n, x.shape[1])), np.empty((p, n), dtype=np.complex128)
    for k, scale in enumerate(unknowns.scale.tolist()):
        h = STEP * scale * np.eye(p)[k]
        ends = [Oscillator.driven(unknowns.applied(values + side * h), dof) for side in (1.0, -1.0)]
        omegas = [end.omega(hz) for end in ends]
        above, below = (
            HarmonicBalance(e, harmonics).residual(x, w) for e, w in zip(ends, omegas, strict=True)
        )
        over, under = (transmissibility(e, w, x) for e, w in zip(ends, omegas, strict=True))
        residual[k] = (above - below) / (2 * STEP * scale)
        ratio[k] = (over - under) / (2 * STEP * scale)
    jacobian = HarmonicBalance(response.plant, harmonics).jacobian(x, response.omega)
    moved = -np.linalg.solve(jacobian, residual.transpose(1, 2, 0))
    base = response.plant.base(response.omega)[:, None]
    slope = ratio.T + (moved[:, 1] - 1j * moved[:, 2]) / base
    return np.asarray(slope / response.ratio[:, None])


def _miss(response: Response, points: Points) -> Array:
    """How far the response misses each point: |ln T|, with the phase where there is one."""
    miss = np.log(np.abs(response.ratio) / points.magnitude)
    turn = np.angle(response.ratio * np.exp(-1j * np.nan_to_num(points.phase)))
    distance = np.hypot(miss, np.where(points.phased, turn, 0.0))
    return np.where(response.good, distance, np.inf)
