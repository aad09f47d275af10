"""The coupled platform over a driven base: equations of six coordinates.

Nondimensional, in the platform's own units: L20, its mass and sqrt(k1/m), so that results stand
beside those of an Oscillator. Forces come from the plant's own `rates`, evaluated for many instants
at once.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from qzs_rig.mechanics import rigid_body
from qzs_rig.mechanics.equilibrium import equilibrium
from qzs_rig.mechanics.geometry import Geometry, axes_of, quaternion
from qzs_rig.samples import Array
from qzs_rig.units import GRAVITY

COORDINATES = 6
"""Centre of mass x, y, z; then the vector part of the attitude's quaternion. Of the world, z up."""
_STEP = 1e-150


@dataclass(frozen=True)
class Plate:
    """`geometry` (SI) whose base moves along or about `dof` as `amplitude` Ω^-falloff cos Ωτ, in
    L20 or rad."""

    geometry: Geometry
    dof: str
    amplitude: float
    falloff: int = 0

    @cached_property
    def scaled(self) -> Geometry:
        """The geometry in units of L20, mass and k1."""
        g = self.geometry
        force, energy = g.k1 * g.L20, g.k1 * g.L20**2
        critical = float(np.sqrt(g.k1 * g.mass))
        shifts = [c / critical for c in g.damping[:2]]
        turns = [c / (critical * g.L20**2) for c in g.damping[2:]]
        lengths = {
            name: getattr(g, name) / g.L20 for name in ('L10', 'L20', 'L1', 'L0', 'span', 'height')
        }
        return replace(
            g,
            k1=1.0,
            k2=g.k2 / g.k1,
            k3=g.k3 / g.k1,
            hinge=g.hinge / energy,
            level=g.level / force,
            mass=1.0,
            inertia_z=g.inertia_z / (g.mass * g.L20**2),
            inertia_xy=g.inertia_xy / (g.mass * g.L20**2),
            damping=(*shifts, *turns),
            **lengths,
        )

    @cached_property
    def _constants(self) -> tuple[Any, Any]:
        g = self.scaled
        gravity = GRAVITY * self.geometry.mass / (self.geometry.k1 * self.geometry.L20)
        body = (1.0, g.height, g.inertia_z, g.inertia_xy, *g.damping, g.level, gravity)
        return g.springs, body

    @cached_property
    def rest(self) -> Array:
        """Coordinates (6,) on a base at rest."""
        z, x, yaw, pitch, y, roll = equilibrium(self.geometry).pose
        _, i, j, k = attitude = quaternion(yaw, pitch, roll)
        up = axes_of(attitude[None])[2][0]
        centre = np.array([x, y, z]) / self.geometry.L20
        return np.concatenate([centre + self.scaled.height * up, [i, j, k]])

    def base(self, omega: float) -> float:
        """Amplitude of the base."""
        return float(self.amplitude * omega ** float(-self.falloff))

    def residual(self, q: Any, dq: Any, ddq: Any, omega: float, angle: Array) -> Any:
        """(6, ...): coordinates' accelerations over what the forces give them, at the phases
        `angle` of the base; q, dq, ddq are (6, ...), real or complex."""
        springs, body = self._constants
        x, y, z, i, j, k = q
        di, dj, dk = dq[3:]
        w = np.sqrt(1.0 - i * i - j * j - k * k)
        dw = -(i * di + j * dj + k * dk) / w
        ddi, ddj, ddk = ddq[3:]
        ddw = -(i * ddi + j * ddj + k * ddk + di * di + dj * dj + dk * dk + dw * dw) / w
        state = (x, y, z, *dq[:3], w, i, j, k, *_turning((w, i, j, k), (dw, di, dj, dk)))
        slope = rigid_body.rates(np.sqrt, springs, body, self._row(omega, angle), state)
        turned = _turning((w, i, j, k), (ddw, ddi, ddj, ddk))
        return np.stack(
            [a - b for a, b in zip((*ddq[:3], *turned), (*slope[3:6], *slope[10:]), strict=True)]
        )

    def slopes(self, q: Array, dq: Array, ddq: Array, omega: float, angle: Array) -> Array:
        """(3, 6, 6, n): slope of each residual in each coordinate, velocity, acceleration, at n
        instants, by complex step: exact to rounding."""
        kick = 1j * _STEP * np.eye(3 * COORDINATES).reshape(3, COORDINATES, 3 * COORDINATES, 1)
        moved = [part[:, None, :] + kick[n] for n, part in enumerate((q, dq, ddq))]
        found = self.residual(moved[0], moved[1], moved[2], omega, angle).imag / _STEP
        return np.asarray(
            np.moveaxis(found.reshape(COORDINATES, 3, COORDINATES, -1), 0, 1), dtype=np.float64
        )

    def _row(self, omega: float, angle: Array) -> tuple[Any, ...]:
        """The base as `rigid_body.rates` takes it; level unless it is turned."""
        v, dv = self.base(omega) * np.cos(angle), -self.base(omega) * omega * np.sin(angle)
        still, one = np.zeros_like(angle), np.ones_like(angle)
        moves = {'vertical': (still, v, still, dv), 'horizontal': (v, still, dv, still)}
        shift = moves.get(self.dof, (still,) * 4)
        if self.dof in moves:
            return (*shift, 0.0, *(still,) * 12)
        c, s = np.cos(v), np.sin(v)
        if self.dof == 'vertical_rotation':
            return (*shift, 1.0, c, s, still, -s, c, still, still, still, one, still, still, dv)
        return (*shift, 1.0, c, still, -s, still, one, still, s, still, c, still, dv, still)

    def seen(self, q: Array) -> Array:
        """(n,): position or angle of the plate's centre along `dof` at coordinates q (6, n); for
        `vertical` negative, as the paper's x points down."""
        x, _, z, i, j, k = q
        w = np.sqrt(1.0 - i * i - j * j - k * k)
        height = self.scaled.height
        return np.asarray(
            {
                'vertical': lambda: -(z - height * (1.0 - 2.0 * (i * i + j * j))),
                'horizontal': lambda: x - height * 2.0 * (i * k + w * j),
                'vertical_rotation': lambda: np.arctan2(
                    2.0 * (i * j + w * k), 1.0 - 2.0 * (j * j + k * k)
                ),
                'horizontal_rotation': lambda: np.arcsin(2.0 * (w * j - i * k)),
            }[self.dof]()
        )


def _turning(q: tuple[Any, ...], dq: tuple[Any, ...]) -> tuple[Any, Any, Any]:
    """Twice the vector part of conj(q) dq: angular velocity in the plate's frame; of the second
    derivative of q, angular acceleration."""
    w, i, j, k = q
    dw, di, dj, dk = dq
    return (
        2.0 * (w * di - i * dw - j * dk + k * dj),
        2.0 * (w * dj - j * dw - k * di + i * dk),
        2.0 * (w * dk - k * dw - i * dj + j * di),
    )
