"""Where the springs of the platform are and how stiff each one is, in SI, and the plate's attitude:
yaw about z, then pitch about the turned y, then roll about the plate's x.

The attitude is not scipy's Rotation: that takes no complex angles, gives no accelerations of
angles, and a platform would start later by the time its package takes to import.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from qzs_rig.mechanics.platform import Platform
from qzs_rig.mechanics.restoring.geometric import HINGE, overturning
from qzs_rig.parameters import RunSpec
from qzs_rig.samples import Array
from qzs_rig.units import DOFS, GRAVITY


def rotation(yaw: Any, pitch: Any, roll: Any) -> Any:
    """Matrix (3, 3) whose columns are the plate's axes; real or complex."""
    (sy, sp, sr), (cy, cp, cr) = np.sin([yaw, pitch, roll]), np.cos([yaw, pitch, roll])
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def turning_axes(yaw: Any, pitch: Any) -> Any:
    """Axes (3, 3), one a row, about which yaw, pitch and roll turn the plate; base frame."""
    sy, cy, sp, cp = np.sin(yaw), np.cos(yaw), np.sin(pitch), np.cos(pitch)
    return np.array([[0.0 * yaw, 0.0 * yaw, 1.0 + 0.0 * yaw], [-sy, cy, 0.0 * yaw],
                     [cy * cp, sy * cp, -sp]])  # fmt: skip


class Angles(NamedTuple):
    """Yaw, pitch, roll (n, 3) in rad with their rates and accelerations."""

    angle: Array
    rate: Array
    acceleration: Array


def angles(attitude: Array, rate: Array, acceleration: Array) -> Angles:
    """Angles of unit quaternions (n, 4), w first, with angular velocity and acceleration (n, 3) in
    the plate's frame. Yaw and roll lie within +-pi; a pitch of +-pi/2 is a singularity."""
    w, x, y, z = attitude.T
    yaw = np.arctan2(2.0 * (x * y + w * z), 1.0 - 2.0 * (y * y + z * z))
    pitch = np.arcsin(np.clip(2.0 * (w * y - x * z), -1.0, 1.0))
    roll = np.arctan2(2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y))
    sp, cp, sr, cr = np.sin(pitch), np.cos(pitch), np.sin(roll), np.cos(roll)
    along, across = rate[:, 1] * cr - rate[:, 2] * sr, rate[:, 1] * sr + rate[:, 2] * cr
    dyaw, dpitch = across / cp, along
    droll = rate[:, 0] + sp * dyaw
    ddpitch = acceleration[:, 1] * cr - acceleration[:, 2] * sr - droll * across
    ddyaw = acceleration[:, 1] * sr + acceleration[:, 2] * cr + droll * along
    ddyaw = (ddyaw + dyaw * sp * dpitch) / cp
    ddroll = acceleration[:, 0] + cp * dpitch * dyaw + sp * ddyaw
    return Angles(
        np.stack([yaw, pitch, roll], axis=1),
        np.stack([dyaw, dpitch, droll], axis=1),
        np.stack([ddyaw, ddpitch, ddroll], axis=1),
    )


def axes_of(attitude: Array) -> tuple[Array, Array, Array]:
    """The plate's x, y and z axis (n, 3) each, for unit quaternions (n, 4), w first."""
    w, x, y, z = attitude.T
    return (
        _columns(1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)),
        _columns(2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)),
        _columns(2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)),
    )


def quaternion(yaw: float, pitch: float, roll: float) -> Array:
    """Unit quaternion (4,), w first, of an attitude."""
    (sy, sp, sr), (cy, cp, cr) = (f(0.5 * np.array([yaw, pitch, roll])) for f in (np.sin, np.cos))
    return np.array(
        [
            cy * cp * cr + sy * sp * sr,
            cy * cp * sr - sy * sp * cr,
            cy * sp * cr + sy * cp * sr,
            sy * cp * cr - cy * sp * sr,
        ]
    )


def turned_by(first: Array, second: Array) -> Array:
    """Quaternion (4,) of turning by `first`, then by `second` about the turned axes."""
    (w, x, y, z), (a, b, c, d) = first, second
    return np.array(
        [
            w * a - x * b - y * c - z * d,
            w * b + x * a + y * d - z * c,
            w * c - x * d + y * a + z * b,
            w * d + x * c - y * b + z * a,
        ]
    )


def _columns(x: Array, y: Array, z: Array) -> Array:
    return np.stack([x, y, z], axis=1)


SIX = (*DOFS, 'horizontal_y', 'horizontal_rotation_x')
"""The four named degrees of freedom, then the second horizontal axis (y) and the rotation about
x (roll). Attitude is yaw about z, then pitch about the turned y, then roll about the plate's x."""


@dataclass(frozen=True)
class Geometry:
    """Springs, plate and damping of the coupled platform. Base frame, z up, m, kg, N, rad.

    The origin is the plate's centre at the working point, level with the base anchors. Plate
    anchors lie at radius `L0` on +-x and +-y of the plate, base anchors at `L0` + `span`, the
    central spring's at (0, 0, -`L10`). `k2` and `k3` are the sums of four springs. `hinge` turns
    the plate back with hinge sin(angle); `level` is the constant upward force on its centre that
    leaves platform.m at rest at the working point; `mass` has platform.payload_trim on top.
    `damping` acts on translation and rotation relative to the base, in the order of DOFS, the
    horizontal values about both axes.
    """

    k1: float
    k2: float
    k3: float
    L10: float
    L20: float
    L1: float
    L0: float
    span: float
    hinge: float
    level: float
    mass: float
    height: float
    inertia_z: float
    inertia_xy: float
    damping: tuple[float, ...]

    @classmethod
    def from_spec(cls, spec: RunSpec) -> Geometry:
        """The coupled platform of a run; raises InputError for one that cannot be built."""
        platform = Platform.from_spec(spec)
        A, k3, L1, L0, a, _ = platform.design.ratios
        k1, L20, mass = platform.stiffness[0], abs(platform.length[0]), platform.mass[0]
        hinge = spec.optional('platform.hinge')
        outward = overturning(platform.design) * k1 * L20**2
        return cls(
            k1=k1,
            k2=A * k1,
            k3=k3 * k1,
            L10=spec.number('platform.L10'),
            L20=L20,
            L1=L1 * L20,
            L0=L0 * L20,
            span=a * L20,
            hinge=HINGE * outward if hinge is None else hinge,
            level=spec.number('platform.m') * GRAVITY - k3 * k1 * L1 * L20,
            mass=mass,
            height=spec.number('platform.cm_height'),
            inertia_z=platform.mass[2],
            inertia_xy=platform.mass[3],
            damping=platform.damping,
        )

    @property
    def springs(self) -> tuple[float, ...]:
        """What `wrench` takes: constants of one suspension and one leaf spring first."""
        suspension, leaf = 0.25 * self.k2, 0.25 * self.k3 * self.span
        return (
            *(suspension, suspension * self.L20, leaf, self.span, self.L1),
            *(self.L0, self.L0 + self.span, self.k1, self.L10, 0.5 * self.hinge),
        )
