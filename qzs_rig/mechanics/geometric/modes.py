"""Small motions about the equilibrium: stiffness, mass, frequencies, shapes, coupling."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from qzs_rig.mechanics.geometric.energy import stiffness
from qzs_rig.mechanics.geometric.equilibrium import Equilibrium, equilibrium
from qzs_rig.mechanics.geometric.geometry import SIX, Geometry
from qzs_rig.mechanics.geometric.pose import rotation, turning_axes
from qzs_rig.samples import Array

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
