"""First principles along one degree of freedom at a time, the others held at the working point:
slopes of the coupled platform's energy (docs/geometric.md)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from qzs_rig.mechanics.restoring.closed_form import vertical, vertical_stiffness
from qzs_rig.mechanics.restoring.law import Design, RestoringLaw, Root, Taylor
from qzs_rig.parameters import Parameter

HINGE = 2.0
"""Stiffness of the hinges where nobody sets it, over the torque a radian with which the compressed
suspension springs turn the plate out of line."""

DOMAIN = (math.inf, math.inf, math.pi, math.pi)
"""|w| below which the formulas hold. Horizontally the plate meets a base anchor at |w| = a."""
_SQUARE = math.pi * math.pi
_EDGE = 1e-300
"""Keeps 0/0 out at theta = pi and changes no bit elsewhere."""


def overturning(design: Design) -> float:
    """Torque over k1 L20² and angle with which the suspension springs turn the plate out of line
    in yaw, half of it in pitch; positive as long as they are compressed."""
    A, _, _, L0, a, _ = design.ratios
    return float(A * (1.0 / a - 1.0) * L0 * (L0 + a))


_HALF_SINE = tuple(1.0 / (2 * n * (2 * n + 1)) for n in range(12, 0, -1))
"""Power series of sin(theta/2), innermost first: rounding is all it leaves within +-pi. Plain
arithmetic gives the same bits in the interpreter, numpy and numba, whose own sines differ."""


def _horizontal(rsqrt: Root) -> Any:
    """Two springs along the motion, linear together; two across it; the central one."""

    def force(design: Any, x: Any) -> Any:
        A, _, _, _, a, _ = design
        return x * (1.0 + A - 0.5 * A * rsqrt(a * a + x * x))

    return force


def _vertical_rotation(rsqrt: Root) -> Any:
    """Four springs from radius L0 to R = L0 + a, and the hinges; the leaves stay level."""

    def torque(design: Any, theta: Any) -> Any:
        A, _, _, L0, a, _ = design
        R = L0 + a
        y, series = 0.5 * theta, 1.0
        for part in _HALF_SINE:
            series = 1.0 - part * (y * y) * series
        # the root adds nothing but refuses what is beyond the domain, where the sign would be wrong
        s = y * series + 0.0 * rsqrt(_SQUARE - theta * theta)
        square, r = 1.0 - s * s, rsqrt(a * a + 4.0 * L0 * R * s * s)
        sine = 2.0 * s * square * rsqrt(square + _EDGE)
        return sine * A * R * (1.0 - r + HINGE * (1.0 / a - 1.0))

    return torque


def _horizontal_rotation(rsqrt: Root) -> Any:
    """The two arms that the plate dips, and the hinges; the other two arms lie on its axis."""

    def torque(design: Any, theta: Any) -> Any:
        A, k3, _, L0, a, _ = design
        R = L0 + a
        y, series = 0.5 * theta, 1.0
        for part in _HALF_SINE:
            series = 1.0 - part * (y * y) * series
        s = y * series + 0.0 * rsqrt(_SQUARE - theta * theta)
        square, r = 1.0 - s * s, rsqrt(a * a + 4.0 * L0 * R * s * s)
        sine, cosine = 2.0 * s * square * rsqrt(square + _EDGE), 1.0 - 2.0 * s * s
        span = R - L0 * cosine
        leaf = 0.5 * k3 * a * a * L0 * (R * cosine - L0) * r / (span * span)
        suspension = 0.5 * A * R * (1.0 - r)
        return sine * (suspension + leaf + HINGE * A * R * (1.0 / a - 1.0))

    return torque


def _horizontal_stiffness(design: Any, x: Any) -> Any:
    A, _, _, _, a, _ = design
    return 1.0 + A - 0.5 * A * a * a / np.sqrt(a * a + x * x) ** 3


def _vertical_rotation_stiffness(design: Any, theta: Any) -> Any:
    A, _, _, L0, a, _ = design
    R = L0 + a
    length = np.sqrt(a * a + 4.0 * L0 * R * np.sin(0.5 * theta) ** 2)
    bracket = 1.0 - 1.0 / length + HINGE * (1.0 / a - 1.0)
    return A * R * (np.cos(theta) * bracket + np.sin(theta) ** 2 * L0 * R / length**3)


def _horizontal_rotation_stiffness(design: Any, theta: Any) -> Any:
    A, k3, _, L0, a, _ = design
    R, c, s2 = L0 + a, np.cos(theta), np.sin(theta) ** 2
    length = np.sqrt(a * a + 4.0 * L0 * R * np.sin(0.5 * theta) ** 2)
    span, lift = R - L0 * c, R * c - L0
    slope = c * lift - s2 * (R + lift * (L0 * R / length**2 + 2.0 * L0 / span))
    leaf = 0.5 * k3 * a * a * L0 * slope / (length * span * span)
    spring = 0.5 * A * R * (c * (1.0 - 1.0 / length) + s2 * L0 * R / length**3)
    return spring + leaf + c * HINGE * A * R * (1.0 / a - 1.0)


def taylor(design: Design) -> Taylor:
    """(c1, c2, c3) of c1 w + c2 w² + c3 w³; the vertical's are those of Eq (8)."""
    A, k3, _, L0, a, b = design.ratios
    R, hinge = L0 + a, HINGE * A * (L0 + a) * (1.0 / a - 1.0)
    yaw, stretch = A * R * (1.0 - 1.0 / a) + hinge, A * L0 * R * R / (2.0 * a**3)
    pitch = 0.5 * (A * R * (1.0 - 1.0 / a) + k3 * L0) + hinge
    leaf = -0.5 * k3 * L0 * (R / (2.0 * a) + L0 * R / (2.0 * a * a) + L0 / a)
    return (
        (1.0 + A - A / a + k3, -b / (2.0 * a * a), A / (2.0 * a**3) - k3 / (2.0 * a * a)),
        (1.0 + A - 0.5 * A / a, 0.0, A / (4.0 * a**3)),
        (yaw, 0.0, stretch - yaw / 6.0),
        (pitch, 0.0, 0.5 * stretch + leaf - pitch / 6.0),
    )


GEOMETRIC = RestoringLaw(
    'geometric',
    'first principles, docs/geometric.md; vertical: Wang et al. 2022, Eq (8)',
    taylor,
    (
        vertical,
        _horizontal,
        _vertical_rotation,
        _horizontal_rotation,
    ),
    (
        vertical_stiffness,
        _horizontal_stiffness,
        _vertical_rotation_stiffness,
        _horizontal_rotation_stiffness,
    ),
    DOMAIN,
    odd=('horizontal', 'vertical_rotation', 'horizontal_rotation'),
    couples=(
        Parameter(
            'platform.L10',
            float,
            0.0,
            'm',
            'coupled only: natural length of the central spring, unstressed at the working point',
            0.0,
        ),
        Parameter(
            'platform.hinge',
            float,
            None,
            'N m/rad',
            'coupled only: rotational stiffness of all hinges; unset: twice what the suspension '
            'springs turn the plate out with; 0: ideal ball joints, with which it falls over',
            0.0,
        ),
        Parameter(
            'platform.cm_height',
            float,
            0.0,
            'm',
            "coupled only: payload's centre of mass above the plate",
        ),
    ),
)
