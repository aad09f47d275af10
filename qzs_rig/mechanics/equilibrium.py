"""The coupled platform about its rest: the one energy that every force is the slope of, with slope
and curvature over the six coordinates; the pose of rest; small motions about it, their frequencies,
shapes and coupling."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from qzs_rig.errors import InputError
from qzs_rig.mechanics.geometry import SIX, Geometry, rotation, turning_axes
from qzs_rig.mechanics.rigid_body import wrench
from qzs_rig.samples import Array
from qzs_rig.units import GRAVITY

ARMS = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
_STEP = 1e-150


def elastic(geometry: Geometry, centre: Any, turn: Any) -> Any:
    """Energy in J of all springs, plate centre (3,) and attitude (3, 3) in the base frame.

    Real or complex. The leaf energy depends on the inclination phi of an arm alone, tan(phi) =
    drop / horizontal distance: k3/4 (span² sec(phi) + span L1 asinh(tan(phi))). On the axis its
    slope is the leaf term of Wang et al. 2022, Eq (8).
    """
    g = geometry
    arms = centre + g.L0 * ARMS @ turn.T - (g.L0 + g.span) * ARMS
    length = np.sqrt((arms**2).sum(axis=1))
    across = np.sqrt(arms[:, 0] ** 2 + arms[:, 1] ** 2)
    suspension = g.k2 / 8.0 * (length - g.L20) ** 2
    bent = g.span * length / across + g.L1 * np.arcsinh(-arms[:, 2] / across)
    leaf = g.k3 / 4.0 * g.span * bent
    below = centre + np.array([0.0, 0.0, g.L10])
    central = 0.5 * g.k1 * (np.sqrt((below**2).sum()) - g.L10) ** 2
    hinge = 0.5 * g.hinge * (3.0 - np.trace(turn))
    return (suspension + leaf).sum() + central + hinge


def potential(geometry: Geometry, pose: Any) -> Any:
    """Elastic energy, weight and levelling force in J at `pose` (6,) in the order of SIX, on a
    level base. Real or complex."""
    centre, turn = np.array([pose[1], pose[4], pose[0]]), rotation(pose[2], pose[3], pose[5])
    weight = geometry.mass * GRAVITY * (pose[0] + geometry.height * turn[2, 2])
    return elastic(geometry, centre, turn) + weight - geometry.level * pose[0]


def gradient(geometry: Geometry, pose: Any) -> Any:
    """Slope (6,) of `potential` at `pose` (6,), both in the order of SIX; N and N m.

    Minus the force on each coordinate. Real or complex.
    """
    z, x, yaw, pitch, y, roll = pose
    turn = rotation(yaw, pitch, roll)
    axes = (*turn[:, 0].tolist(), *turn[:, 1].tolist())
    pull = np.array(wrench(cmath.sqrt, geometry.springs, (x, y, z), axes))
    weight = geometry.mass * GRAVITY
    # the weight acts at `height` along the plate's z
    lever = geometry.height * turn[:, 2]
    torque = pull[3:] + weight * np.array([-lever[1], lever[0], 0.0 * lever[0]])
    force = pull[:3] + np.array([0.0, 0.0, geometry.level - weight])
    along = turning_axes(yaw, pitch) @ torque
    slope = -np.array([force[2], force[0], along[0], along[1], force[1], along[2]])
    return slope if np.iscomplexobj(np.asarray(pose)) else slope.real


def stiffness(geometry: Geometry, pose: Array) -> Array:
    """Curvature (6, 6) of `potential` at `pose`, by complex step: exact to rounding."""
    columns = []
    for n in range(6):
        ahead = np.asarray(pose, dtype=complex)
        ahead[n] += 1j * _STEP
        columns.append(gradient(geometry, ahead).imag / _STEP)
    return np.stack(columns, axis=1)


STEPS = 200
BALANCED = 1e-13
"""Residual over k1 L20 (torques: over k1 L20²) that counts as none."""


class Equilibrium(NamedTuple):
    """A pose of rest (6,) in the order of SIX, with its residual over k1 L20 and Newton's steps."""

    pose: Array
    residual: float
    steps: int


def equilibrium(geometry: Geometry, start: Array | None = None) -> Equilibrium:
    """The pose of rest that Newton's method with a line search on the energy slides down to.

    Starts at the working point. A direction of negative curvature is taken as positive, so it
    runs downhill, not to a summit; a symmetric start stays symmetric, and may rest on a saddle
    (see Modes.stable). scipy's trust regions judge a step by the energy alone, whose rounding ends
    them at a residual a thousand times as large. Raises InputError where there is none within L20
    and 1 rad.
    """
    pose = np.zeros(6) if start is None else np.array(start, dtype=float)
    lengths = np.array([geometry.L20, geometry.L20, 1.0, 1.0, geometry.L20, 1.0])
    unit = geometry.k1 * geometry.L20**2
    residual, steps = np.inf, 0
    for steps in range(STEPS):
        slope = gradient(geometry, pose) * lengths / unit
        residual = float(np.abs(slope).max())
        if residual < BALANCED:
            return Equilibrium(pose, residual, steps)
        curvature = stiffness(geometry, pose) * np.outer(lengths, lengths) / unit
        move = _downhill(curvature, slope)
        shorter = _line_search(geometry, pose, lengths * move, float(slope @ move) * unit)
        if shorter == 0.0:
            break
        pose = pose + shorter * lengths * move
        if not np.all(np.abs(pose) < lengths):
            break
    # a quasi-zero stiffness leaves the pose known to the cube root of rounding only
    if residual < 1e3 * BALANCED:
        return Equilibrium(pose, residual, steps)
    raise InputError(
        f'no equilibrium near the working point: {residual:.3g} k1 L20 left after {steps} steps; '
        'bring platform.payload_trim nearer to 0 or raise platform.hinge'
    )


def _downhill(curvature: Array, slope: Array) -> Array:
    values, vectors = np.linalg.eigh(0.5 * (curvature + curvature.T))
    along = vectors.T @ slope
    # at a quasi-zero stiffness the tangent has no say: at most a tenth of a length a step
    least = np.maximum(1e-9, 10.0 * np.abs(along))
    return np.asarray(-vectors @ (along / np.maximum(np.abs(values), least)))


def _line_search(geometry: Geometry, pose: Array, move: Array, fall: float) -> float:
    before = float(potential(geometry, pose))
    rounding = 1e-15 * geometry.k1 * geometry.L20**2
    share = 1.0
    while share > 1e-6:
        after = float(potential(geometry, pose + share * move))
        if after <= before + 1e-4 * share * fall + rounding:
            return share
        share *= 0.5
    return 0.0


ROUNDING = 1e-12
"""Squared frequency over k1/m, and stiffness over the greatest, that count as none."""


class Coupling(NamedTuple):
    """Off-diagonal stiffness and mass of two coordinates (SI); over sqrt(M_ii M_jj), and
    stiffness over the greatest squared frequency, they are pure numbers: 0 is none."""

    first: str
    second: str
    stiffness: float
    mass: float
    stiffness_ratio: float
    mass_ratio: float


@dataclass(frozen=True)
class Modes:
    """M q'' + K q = 0 about `rest`; rows, columns and shapes in the order of SIX, SI.

    `squares` (6,) are the squared angular frequencies, ascending, negative where the equilibrium
    is unstable, 0 where it is neutral (quasi-zero stiffness). Column n of `shapes` is mode n,
    M-normalised, its largest coordinate positive. `shares` (6, 6): column n is the part of mode
    n's kinetic energy that goes with each coordinate.
    """

    rest: Equilibrium
    stiffness: Array
    mass: Array
    squares: Array
    shapes: Array
    shares: Array

    @property
    def stable(self) -> bool:
        """Whether no small motion grows."""
        return bool((self.squares >= 0.0).all())

    @property
    def frequencies_hz(self) -> tuple[float | None, ...]:
        """Natural frequencies; None where a mode does not swing but grows."""
        return tuple(math.sqrt(s) / (2 * math.pi) if s >= 0.0 else None for s in self.squares)

    @property
    def growth(self) -> tuple[float | None, ...]:
        """Growth rates in 1/s of the modes that fall over."""
        return tuple(math.sqrt(-s) if s < 0.0 else None for s in self.squares)

    @property
    def couplings(self) -> tuple[Coupling, ...]:
        """Every pair of coordinates that pull on each other through K or M."""
        unit, fastest = np.sqrt(np.diag(self.mass)), float(np.abs(self.squares).max())
        found = []
        for i, j in zip(*np.triu_indices(6, 1), strict=True):
            k, m = float(self.stiffness[i, j]), float(self.mass[i, j])
            reach = float(unit[i] * unit[j])
            ratios = k / (reach * fastest), m / reach
            if max(abs(ratio) for ratio in ratios) > ROUNDING:
                found.append(Coupling(SIX[i], SIX[j], k, m, *ratios))
        return tuple(found)


def modes(geometry: Geometry) -> Modes:
    """Modes about the equilibrium on a level base; raises InputError where there is none."""
    rest = equilibrium(geometry)
    K = stiffness(geometry, rest.pose)
    K = 0.5 * (K + K.T)
    M = mass(geometry, rest.pose)
    # M = L L', so that L^-1 K L^-T has orthonormal vectors
    root = np.linalg.inv(np.linalg.cholesky(M))
    squares, vectors = np.linalg.eigh(root @ K @ root.T)
    # what remains of a quasi-zero stiffness is the rounding of its terms, of either sign
    squares[np.abs(squares) < ROUNDING * geometry.k1 / geometry.mass] = 0.0
    shapes = root.T @ vectors
    shares = shapes * (M @ shapes)
    signs = np.sign(shapes[np.abs(shares).argmax(axis=0), np.arange(6)])
    return Modes(rest, K, M, squares, shapes * signs, shares)


def cautions(geometry: Geometry, hinge_given: bool) -> list[str]:
    """What a user should know before trusting a run of the coupled platform."""
    found, said = modes(geometry), []
    for n in np.flatnonzero(found.squares < 0.0):
        dof = SIX[int(np.abs(found.shares[:, n]).argmax())]
        said.append(
            f'the coupled platform falls over: {dof} grows by a factor e in '
            f'{1.0 / np.sqrt(-found.squares[n]):.3g} s; raise platform.hinge (see qzs-rig modes)'
        )
    if not hinge_given and geometry.hinge > 0.0:
        said.append(
            f'hinges of {geometry.hinge:.4g} N m/rad hold the plate level (platform.hinge is '
            'unset); with ideal ball joints a platform under condition (16) falls over'
        )
    return said


def mass(geometry: Geometry, pose: Array) -> Array:
    """Mass matrix (6, 6) at `pose`: kinetic energy is q' M q' / 2; kg, kg m, kg m²."""
    _, _, yaw, pitch, _, roll = pose
    turn, axes = rotation(yaw, pitch, roll), turning_axes(yaw, pitch)
    moves, turns = np.zeros((3, 6)), np.zeros((3, 6))
    moves[[2, 0, 1], [0, 1, 4]] = 1.0
    turns[:, [2, 3, 5]] = axes.T
    moves += np.cross(turns, geometry.height * turn[:, 2], axis=0)
    spin = turn.T @ turns
    inertia = np.diag([geometry.inertia_xy, geometry.inertia_xy, geometry.inertia_z])
    return np.asarray(geometry.mass * moves.T @ moves + spin.T @ inertia @ spin)
