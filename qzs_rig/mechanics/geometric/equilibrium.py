"""Where the coupled platform comes to rest on a level base."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from qzs_rig.errors import InputError
from qzs_rig.mechanics.geometric.energy import gradient, potential, stiffness
from qzs_rig.mechanics.geometric.geometry import Geometry
from qzs_rig.samples import Array

STEPS = 200
ROUNDING = 1e-13
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
        if residual < ROUNDING:
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
    if residual < 1e3 * ROUNDING:
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
