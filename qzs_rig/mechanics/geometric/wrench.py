"""Force and torque of the springs: the slope of `energy.elastic`, derived by hand."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

Function = Callable[..., Any]


def bind(sqrt: Function) -> tuple[Function, Function]:
    """`arm` and `wrench` around a square root, math.sqrt or a complex one."""

    def arm(springs: Any, x: Any, y: Any, z: Any) -> Any:
        """Force (3) on the base's end of an arm that points along (x, y, z).

        The suspension spring pulls with k2/4 (1 - L20/l) along the arm; the leaf spring's force
        is k3/4 span/l (span q - L1), q = z/h, across it: inclination knows no length.
        """
        k, kL, leaf, span, L1, _, _, _, _, _ = springs
        hh = x * x + y * y
        h, r = sqrt(hh), 1.0 / sqrt(hh + z * z)
        q, c = z / h, k - kL * r
        g = leaf * r * (span * q - L1)
        s = c - g * q / h
        return s * x, s * y, c * z + g

    def wrench(springs: Any, centre: Any, axes: Any) -> Any:
        """Force on the plate and torque about its centre (6), base frame.

        `springs` is Geometry.springs, `centre` (3) the plate's centre, `axes` (6) its x and y
        axis. Opposite arms are formed as mirror images, so that a symmetric pose has exactly no
        force off its symmetry.
        """
        _, _, _, _, _, L0, R, k1, L10, hinge = springs
        x, y, z = centre
        ax, ay, az, bx, by, bz = axes
        px, py, pz = L0 * ax, L0 * ay, L0 * az
        ux, uy, uz = arm(springs, x + (px - R), y + py, z + pz)
        vx, vy, vz = arm(springs, x - (px - R), y - py, z - pz)
        fx, fy, fz = ux + vx, uy + vy, uz + vz
        ux, uy, uz = ux - vx, uy - vy, uz - vz
        tx, ty, tz = py * uz - pz * uy, pz * ux - px * uz, px * uy - py * ux
        px, py, pz = L0 * bx, L0 * by, L0 * bz
        ux, uy, uz = arm(springs, x + px, y + (py - R), z + pz)
        vx, vy, vz = arm(springs, x - px, y - (py - R), z - pz)
        fx, fy, fz = fx + (ux + vx), fy + (uy + vy), fz + (uz + vz)
        ux, uy, uz = ux - vx, uy - vy, uz - vz
        tx, ty, tz = tx + (py * uz - pz * uy), ty + (pz * ux - px * uz), tz + (px * uy - py * ux)
        below = z + L10
        central = k1
        if L10 != 0.0:
            central = k1 - k1 * L10 / sqrt(x * x + y * y + below * below)
        return (
            -fx - central * x,
            -fy - central * y,
            -fz - central * below,
            -tx - hinge * (bz - (az * bx - ax * bz)),
            -ty - hinge * ((ay * bz - az * by) - az),
            -tz - hinge * (ay - bx),
        )

    return arm, wrench


arm, wrench = bind(math.sqrt)
