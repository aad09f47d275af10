"""Forces on the top plate and its motion as a rigid body, for the interpreter and numba.

Force and torque of the springs are the slope of `energy.elastic`, derived by hand.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

from qzs_rig.mechanics.compiling import kept

STATE = 13
"""Centre of mass (3) and its velocity (3), attitude quaternion w first (4), angular velocity in
the plate's frame (3)."""
BASE = 17
"""A row of base motion: x, z and their velocities, 1 where the base is turned or turning (else 0
and the rest is not read), its axes (9) as rows of world components, angular velocity in its own
frame (3)."""


def arm(sqrt: Any, springs: Any, x: Any, y: Any, z: Any) -> Any:
    """Force (3) on the base's end of an arm that points along (x, y, z), by math's square root, or
    numpy's for arrays and complex numbers.

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


def wrench(sqrt: Any, springs: Any, centre: Any, axes: Any) -> Any:
    """Force on the plate and torque about its centre (6), base frame.

    `springs` is Geometry.springs, `centre` (3) the plate's centre, `axes` (6) its x and y
    axis. Opposite arms are formed as mirror images, so that a symmetric pose has exactly no
    force off its symmetry.
    """
    _, _, _, _, _, L0, R, k1, L10, hinge = springs
    x, y, z = centre
    ax, ay, az, bx, by, bz = axes
    px, py, pz = L0 * ax, L0 * ay, L0 * az
    ux, uy, uz = arm(sqrt, springs, x + (px - R), y + py, z + pz)
    vx, vy, vz = arm(sqrt, springs, x - (px - R), y - py, z - pz)
    fx, fy, fz = ux + vx, uy + vy, uz + vz
    ux, uy, uz = ux - vx, uy - vy, uz - vz
    tx, ty, tz = py * uz - pz * uy, pz * ux - px * uz, px * uy - py * ux
    px, py, pz = L0 * bx, L0 * by, L0 * bz
    ux, uy, uz = arm(sqrt, springs, x + px, y + (py - R), z + pz)
    vx, vy, vz = arm(sqrt, springs, x - px, y - (py - R), z - pz)
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


def rates(sqrt: Any, springs: Any, body: Any, base: Any, state: Any) -> Any:
    """Time derivative of `state`; `body` as of CoupledIntegrator, `base` a row (BASE)."""
    m, height, Iz, Ixy, Cz, Cxy, Cyaw, Ctilt, level, gravity = body
    x, y, z, vx, vy, vz, w, i, j, k, wx, wy, wz = state
    # the plate's axes in the world
    ax, ay, az = 1.0 - 2.0 * (j * j + k * k), 2.0 * (i * j + w * k), 2.0 * (i * k - w * j)
    bx, by, bz = 2.0 * (i * j - w * k), 1.0 - 2.0 * (i * i + k * k), 2.0 * (j * k + w * i)
    cx, cy, cz = 2.0 * (i * k + w * j), 2.0 * (j * k - w * i), 1.0 - 2.0 * (i * i + j * j)
    # the plate's centre and its velocity, relative to the base
    sx, sy = height * wy, height * wx
    px, py, pz = x - height * cx - base[0], y - height * cy, z - height * cz - base[1]
    ux = vx - (sx * ax - sy * bx) - base[2]
    uy = vy - (sx * ay - sy * by)
    uz = vz - (sx * az - sy * bz) - base[3]
    turned = base[4] != 0.0
    if turned:
        X0, X1, X2, Y0, Y1, Y2, Z0, Z1, Z2 = (
            *(base[5], base[6], base[7], base[8], base[9]),
            *(base[10], base[11], base[12], base[13]),
        )
        ox, oy, oz = base[14], base[15], base[16]
        px, py, pz = (X0 * px + X1 * py + X2 * pz, Y0 * px + Y1 * py + Y2 * pz,
                      Z0 * px + Z1 * py + Z2 * pz)  # fmt: skip
        ux, uy, uz = (X0 * ux + X1 * uy + X2 * uz, Y0 * ux + Y1 * uy + Y2 * uz,
                      Z0 * ux + Z1 * uy + Z2 * uz)  # fmt: skip
        ux, uy, uz = (ux - (oy * pz - oz * py), uy - (oz * px - ox * pz),
                      uz - (ox * py - oy * px))  # fmt: skip
        ax, ay, az = (X0 * ax + X1 * ay + X2 * az, Y0 * ax + Y1 * ay + Y2 * az,
                      Z0 * ax + Z1 * ay + Z2 * az)  # fmt: skip
        bx, by, bz = (X0 * bx + X1 * by + X2 * bz, Y0 * bx + Y1 * by + Y2 * bz,
                      Z0 * bx + Z1 * by + Z2 * bz)  # fmt: skip
        cx, cy, cz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    fx, fy, fz, tx, ty, tz = wrench(sqrt, springs, (px, py, pz), (ax, ay, az, bx, by, bz))
    fx, fy, fz = fx - Cxy * ux, fy - Cxy * uy, fz - Cz * uz + level
    rx, ry, rz = (wx * ax + wy * bx + wz * cx, wx * ay + wy * by + wz * cy,
                  wx * az + wy * bz + wz * cz)  # fmt: skip
    if turned:
        rx, ry, rz = rx - ox, ry - oy, rz - oz
    tx, ty, tz = tx - Ctilt * rx, ty - Ctilt * ry, tz - Cyaw * rz
    # torque about the centre of mass, in the plate's frame
    nx = tx * ax + ty * ay + tz * az + height * (fx * bx + fy * by + fz * bz)
    ny = tx * bx + ty * by + tz * bz - height * (fx * ax + fy * ay + fz * az)
    nz = tx * cx + ty * cy + tz * cz
    if turned:
        fx, fy, fz = (X0 * fx + Y0 * fy + Z0 * fz, X1 * fx + Y1 * fy + Z1 * fz,
                      X2 * fx + Y2 * fy + Z2 * fz)  # fmt: skip
    gyro = (Iz - Ixy) * wz
    return (
        *(vx, vy, vz),
        *(fx / m, fy / m, fz / m - gravity),
        0.5 * (-i * wx - j * wy - k * wz),
        0.5 * (w * wx + j * wz - k * wy),
        0.5 * (w * wy + k * wx - i * wz),
        0.5 * (w * wz + i * wy - j * wx),
        *((nx - gyro * wy) / Ixy, (ny + gyro * wx) / Ixy, nz / Iz),
    )


def ahead(s: Any, h: float, r: Any) -> Any:
    """s + h r, component by component."""
    s0, s1, s2, s3, s4, s5, s6, s7, s8, s9, sa, sb, sc = s
    r0, r1, r2, r3, r4, r5, r6, r7, r8, r9, ra, rb, rc = r
    return (
        *(s0 + h * r0, s1 + h * r1, s2 + h * r2, s3 + h * r3, s4 + h * r4, s5 + h * r5),
        *(s6 + h * r6, s7 + h * r7, s8 + h * r8, s9 + h * r9),
        *(sa + h * ra, sb + h * rb, sc + h * rc),
    )


def upright(s: Any) -> Any:
    """The state with its quaternion made a unit one again."""
    x, y, z, vx, vy, vz, w, i, j, k, wx, wy, wz = s
    n = 1.0 / math.sqrt(w * w + i * i + j * j + k * k)
    return x, y, z, vx, vy, vz, w * n, i * n, j * n, k * n, wx, wy, wz


def march(
    springs: Any, body: Any, h: float, state: Any, ends: Any, mids: Any, states: Any, slopes: Any
) -> int:
    """Classical Runge-Kutta from `state` at ends[0] over len(mids) steps of h.

    `ends` and `mids` are rows of base motion at step ends and midpoints. Fills `states` and
    `slopes` at the step ends after the first. Returns the number of good steps: less than
    all where the state left the finite numbers.
    """
    half, sixth, third = 0.5 * h, h / 6.0, h / 3.0
    k1 = rates(math.sqrt, springs, body, ends[0], state)
    for n in range(len(mids)):
        mid, end = mids[n], ends[n + 1]
        k2 = rates(math.sqrt, springs, body, mid, ahead(state, half, k1))
        k3 = rates(math.sqrt, springs, body, mid, ahead(state, half, k2))
        k4 = rates(math.sqrt, springs, body, end, ahead(state, h, k3))
        state = ahead(ahead(ahead(ahead(state, sixth, k1), third, k2), third, k3), sixth, k4)
        state = upright(state)
        k1 = rates(math.sqrt, springs, body, end, state)
        # also false for NaN
        size = abs(k1[3]) + abs(k1[4]) + abs(k1[5]) + abs(k1[10]) + abs(k1[11]) + abs(k1[12])
        if not size < 1e300:
            return n
        states[n], slopes[n] = state, k1
    return len(mids)


@cache
def compiled() -> Any:
    """`march` compiled by numba, the same bits (no fast-math).

    Raises ImportError where numba cannot be imported.
    """
    from numba import float64, int64, types
    from numba.extending import register_jitable

    # `march` finds these by name; compiled into it, they leave one function to keep on disk
    for function in (arm, wrench, rates, ahead, upright):
        register_jitable(function)
    # numba's own types carry no annotations
    pack: Any = types.UniTuple
    constants, rows = pack(float64, 10), float64[:, ::1]
    signature = int64(constants, constants, float64, pack(float64, STATE), *(rows,) * 4)
    return kept(signature, error_model='numpy')(march)
