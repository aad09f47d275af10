"""Steady response at the measured points: on which branch, and how it moves with the parameters."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from qzs_rig.identification.points import Complex, Points
from qzs_rig.identification.unknowns import Unknowns
from qzs_rig.parameters import RunSpec
from qzs_rig.samples import Array
from qzs_rig.theory.balance.harmonic_balance import HarmonicBalance, steady, transmissibility
from qzs_rig.theory.oscillator import Oscillator

WELL = 0.15
"""In units of L20; wells of A = 1.12 lie 0.07 from the middle."""
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


def _better(one: Response, other: Response, points: Points) -> Response:
    """At each point the response that misses it by less."""
    swap = _miss(other, points) < _miss(one, points)
    return replace(
        one,
        x=np.where(swap[:, None], other.x, one.x),
        ratio=np.where(swap, other.ratio, one.ratio),
        good=np.where(swap, other.good, one.good),
    )


def _miss(response: Response, points: Points) -> Array:
    """How far the response misses each point: |ln T|, with the phase where there is one."""
    miss = np.log(np.abs(response.ratio) / points.magnitude)
    turn = np.angle(response.ratio * np.exp(-1j * np.nan_to_num(points.phase)))
    distance = np.hypot(miss, np.where(points.phased, turn, 0.0))
    return np.where(response.good, distance, np.inf)


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


def ends_near(response: Response, frequency_hz: Array) -> NDArray[np.bool_]:
    """Points (n,) whose branch ends, or turns by half, within EDGE of their frequency."""
    ends = np.zeros(len(frequency_hz), dtype=bool)
    for side in (1.0 - EDGE, 1.0 + EDGE):
        beside = followed(response.plant, side * frequency_hz, response.x)
        with np.errstate(divide='ignore', invalid='ignore'):
            turned = np.abs(np.log(np.abs(beside.ratio / response.ratio))) > 0.5
        ends |= ~beside.good | turned
    return ends


def sensitivity(unknowns: Unknowns, values: Array, points: Points, response: Response) -> Complex:
    """Slope of ln(u/v) in the parameters (n, p) at `values`, by implicit differentiation: the
    balance R(x, p) = 0 moves x by -J⁻¹ ∂R/∂p."""
    x, harmonics = response.x, response.x.shape[1] // 2

    def unbalanced(spec: RunSpec) -> Complex:
        """The balance, then u/v, at the same motion and frequency (n, 2H + 2)."""
        there = Oscillator.driven(spec, points.dof)
        omega = there.omega(points.frequency_hz)
        left = HarmonicBalance(there, harmonics).residual(x, omega)
        return np.column_stack([left, transmissibility(there, omega, x)])

    changes = unknowns.slopes(unbalanced, values)
    jacobian = HarmonicBalance(response.plant, harmonics).jacobian(x, response.omega)
    moved = -np.linalg.solve(jacobian, changes[..., :-1].real.transpose(1, 2, 0))
    base = response.plant.base(response.omega)[:, None]
    slope = changes[..., -1].T + (moved[:, 1] - 1j * moved[:, 2]) / base
    return np.asarray(slope / response.ratio[:, None])


def swept_over_steady(plant: Oscillator, omega: Array, rate: Array, x: Array) -> Complex:
    """Ratio (n,) of u/v as swept through `omega` (n,) at dΩ/dτ = `rate` (n,) to u/v settled at
    coefficients x (n, 2H + 1): a sweep shows the steady motion late, to first order in its rate.

    The motion Re Σ X_k(τ) exp(ikφ), φ' = Ω(τ), balances as in the steady state plus, in harmonic k,

        (2ikΩ + 2ζ) X_k' + ikΩ' X_k,       X' = dX/dΩ · Ω',

    and the base V exp(iφ), V = Ĥ Ω^-falloff, accelerates by -V (Ω² - i(1 - 2 falloff) Ω'). The
    second derivative and the products of Ω' that are left out make it good while the correction
    is small.
    """
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


def _complex(x: Array) -> Complex:
    return np.asarray(x[:, 1::2] - 1j * x[:, 2::2])


def iso_limit(half_power_hz: float) -> float:
    """Fastest linear sweep by ISO 7626-2 in Hz/s: 54 f²/Q² Hz a minute, f/Q the half-power
    bandwidth; through a softer or stiffer branch the bandwidth 2ζ f0 stays."""
    return 0.9 * half_power_hz**2
