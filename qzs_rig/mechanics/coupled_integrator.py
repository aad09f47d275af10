"""The coupled platform stepped on the sample grid, its state carried across chunks."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from qzs_rig.errors import DivergenceError
from qzs_rig.mechanics import rigid_body
from qzs_rig.mechanics.equilibrium import equilibrium
from qzs_rig.mechanics.geometry import Geometry, angles, axes_of, quaternion, turned_by
from qzs_rig.mechanics.integrator import Stepper, by_kernel
from qzs_rig.samples import Array
from qzs_rig.units import GRAVITY

FURTHEST_TURN = 1.0
"""Angle in rad between plate and base beyond which arms would collide."""


class CoupledIntegrator(Stepper):
    """Runge-Kutta from sample to sample of the top plate as a rigid body with six degrees of
    freedom, starting at rest relative to the base, in its equilibrium.

    Columns 0-11 of the top motion (n, 18) are position, velocity, acceleration of the four degrees
    of freedom; then y and roll, their velocities, their accelerations. SI, z up, of the plate's
    centre. Diverges where the plate leaves the finite numbers or turns beyond FURTHEST_TURN.
    """

    columns = 18

    def __init__(self, geometry: Geometry, step: float, substeps: int, kernel: str) -> None:
        super().__init__(step, substeps)
        self._geometry = geometry
        fast = by_kernel(kernel, rigid_body.compiled)
        self._march, self._lists = fast or rigid_body.march, fast is None
        self._rest = equilibrium(geometry).pose
        self._body = body(geometry)
        self._state: tuple[float, ...] = ()

    def _begin(self, base: Array) -> Array:
        row = base_rows(base[None])[0]
        self._state = _riding(self._geometry, self._rest, row)
        springs = self._geometry.springs
        slope = rigid_body.rates(math.sqrt, springs, self._body, row.tolist(), self._state)
        top = self._motion(np.array([self._state]), np.array([slope]), base[None])
        return np.asarray(top[0])

    def _advance(self, samples: Array) -> Array:
        nodes = self._nodes(samples)
        ends, mids = base_rows(nodes.ends), base_rows(nodes.mid)
        n = len(mids)
        states: Any = np.empty((n, rigid_body.STATE))
        slopes: Any = np.empty((n, rigid_body.STATE))
        if self._lists:
            ends, mids, states, slopes = ends.tolist(), mids.tolist(), [()] * n, [()] * n
        try:
            good = self._march(
                self._geometry.springs,
                self._body,
                self._step / self._substeps,
                self._state,
                ends,
                mids,
                states,
                slopes,
            )
        except (OverflowError, ZeroDivisionError, ValueError):
            # numbers too large or an arm of no length; what is unfilled is ()
            good = states.index(())
        if good < n:
            raise self._fallen(good // self._substeps, 'left the finite numbers')
        if n:
            self._state = tuple(float(value) for value in states[-1])
        last = slice(self._substeps - 1, None, self._substeps)
        shape = (n // self._substeps, rigid_body.STATE)
        states, slopes = np.reshape(states[last], shape), np.reshape(slopes[last], shape)
        return self._motion(states, slopes, samples[1:])

    def _motion(self, states: Array, slopes: Array, base: Array) -> Array:
        self._refuse_fallen(states, base)
        turn = angles(states[:, 6:10], states[:, 10:], slopes[:, 10:])
        height, (ax, bx, cx) = self._geometry.height, axes_of(states[:, 6:10])
        wx, wy, wz = (states[:, n, None] for n in (10, 11, 12))
        dwx, dwy = slopes[:, 10, None], slopes[:, 11, None]
        # the plate's centre lies `height` below the centre of mass, along the plate's z
        position = states[:, :3] - height * cx
        velocity = states[:, 3:6] - height * (wy * ax - wx * bx)
        lateral = (dwy + wx * wz) * ax - (dwx - wy * wz) * bx
        acceleration = slopes[:, 3:6] - height * (lateral - (wx * wx + wy * wy) * cx)
        named, second = [], []
        for moved, turned in zip((position, velocity, acceleration), turn, strict=True):
            named += [moved[:, 2], moved[:, 0], turned[:, 0], turned[:, 1]]
            second += [moved[:, 1], turned[:, 2]]
        return np.stack(named + second, axis=1)

    def _refuse_fallen(self, states: Array, base: Array) -> None:
        plate, floor = axes_of(states[:, 6:10]), base_rows(base)[:, 5:14].reshape(-1, 3, 3)
        trace = sum(plate[k][:, n] * floor[:, k, n] for k in range(3) for n in range(3))
        fallen = np.asarray(trace < 1.0 + 2.0 * math.cos(FURTHEST_TURN))
        if fallen.any():
            first = int(fallen.argmax())
            raise self._fallen(first, f'turned more than {FURTHEST_TURN:g} rad on the base')

    def _fallen(self, good: int, how: str) -> DivergenceError:
        way_out = (
            'lower excitation.amplitude, raise platform.hinge or platform.substeps (see qzs-rig '
            'modes)'
        )
        return self._divergence(good, f'the coupled plate {how}', way_out)


def body(geometry: Geometry) -> tuple[float, ...]:
    """Mass, inertia, damping and constant forces as `rigid_body.rates` takes them."""
    g = geometry
    return (
        *(g.mass, g.height, g.inertia_z, g.inertia_xy),
        *(g.damping[0], g.damping[1], g.damping[2], g.damping[3]),
        *(g.level, GRAVITY),
    )


def base_rows(base: Array) -> Array:
    """Base motion (n, 8), position and velocity in the order of DOFS, as `rigid_body.rates` takes
    it: (n, rigid_body.BASE)."""
    z, x, yaw, pitch, vz, vx, yaw_rate, pitch_rate = base.T
    sy, cy, sp, cp = np.sin(yaw), np.cos(yaw), np.sin(pitch), np.cos(pitch)
    turned = (yaw != 0.0) | (pitch != 0.0) | (yaw_rate != 0.0) | (pitch_rate != 0.0)
    along = (cy * cp, sy * cp, -sp)
    across = (-sy, cy, np.zeros_like(yaw))
    up = (cy * sp, sy * sp, cp)
    rate = (-sp * yaw_rate, pitch_rate, cp * yaw_rate)
    rows = np.stack([x, z, vx, vz, turned.astype(float), *along, *across, *up, *rate], axis=1)
    return np.ascontiguousarray(rows)


def _riding(geometry: Geometry, rest: Array, row: Array) -> tuple[float, ...]:
    """State of a plate that moves with the base as one body, at pose `rest` relative to it."""
    floor, rate = row[5:14].reshape(3, 3).T, row[14:]
    plate = axes_of(quaternion(rest[2], rest[3], rest[5])[None])
    turn = floor @ np.stack([axis[0] for axis in plate], axis=1)
    centre = floor @ np.array([rest[1], rest[4], rest[0]]) + geometry.height * turn[:, 2]
    yaw, pitch = math.atan2(row[6], row[5]), math.asin(-row[7])
    attitude = turned_by(quaternion(yaw, pitch, 0.0), quaternion(rest[2], rest[3], rest[5]))
    spin = floor @ rate
    position = np.array([row[0], 0.0, row[1]]) + centre
    velocity = np.array([row[2], 0.0, row[3]]) + np.cross(spin, centre)
    values = np.concatenate([position, velocity, attitude, turn.T @ spin])
    return tuple(float(value) for value in values)
