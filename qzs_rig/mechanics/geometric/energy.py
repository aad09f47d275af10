"""The one energy that every force of the coupled platform is the slope of, with its slope and
curvature over the six coordinates from the forces of `motion`."""

from __future__ import annotations

import cmath
from typing import Any

import numpy as np

from qzs_rig.mechanics.geometric.geometry import Geometry
from qzs_rig.mechanics.geometric.motion import wrench
from qzs_rig.mechanics.geometric.pose import rotation, turning_axes
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
