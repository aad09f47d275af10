"""Slope and curvature of the potential over the six coordinates, from the kernel's own wrench."""

from __future__ import annotations

import cmath
from typing import Any

import numpy as np

from qzs_rig.mechanics.geometric.geometry import Geometry
from qzs_rig.mechanics.geometric.pose import rotation, turning_axes
from qzs_rig.mechanics.geometric.wrench import bind
from qzs_rig.samples import Array
from qzs_rig.units import GRAVITY

_, _wrench = bind(cmath.sqrt)
_STEP = 1e-150


def gradient(geometry: Geometry, pose: Any) -> Any:
    """Slope (6,) of `energy.potential` at `pose` (6,), both in the order of SIX; N and N m.

    Minus the force on each coordinate. Real or complex.
    """
    z, x, yaw, pitch, y, roll = pose
    turn = rotation(yaw, pitch, roll)
    axes = (*turn[:, 0].tolist(), *turn[:, 1].tolist())
    wrench = np.array(_wrench(geometry.springs, (x, y, z), axes))
    weight = geometry.mass * GRAVITY
    # the weight acts at `height` along the plate's z
    lever = geometry.height * turn[:, 2]
    torque = wrench[3:] + weight * np.array([-lever[1], lever[0], 0.0 * lever[0]])
    force = wrench[:3] + np.array([0.0, 0.0, geometry.level - weight])
    along = turning_axes(yaw, pitch) @ torque
    slope = -np.array([force[2], force[0], along[0], along[1], force[1], along[2]])
    return slope if np.iscomplexobj(np.asarray(pose)) else slope.real


def stiffness(geometry: Geometry, pose: Array) -> Array:
    """Curvature (6, 6) of `energy.potential` at `pose`, by complex step: exact to rounding."""
    columns = []
    for n in range(6):
        ahead = np.asarray(pose, dtype=complex)
        ahead[n] += 1j * _STEP
        columns.append(gradient(geometry, ahead).imag / _STEP)
    return np.stack(columns, axis=1)
