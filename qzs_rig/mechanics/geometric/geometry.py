"""Where the springs of the platform are and how stiff each one is, in SI."""

from __future__ import annotations

from dataclasses import dataclass

from qzs_rig.mechanics.platform import Platform
from qzs_rig.mechanics.restoring.geometric import HINGE, overturning
from qzs_rig.parameters import RunSpec
from qzs_rig.units import DOFS, GRAVITY

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
