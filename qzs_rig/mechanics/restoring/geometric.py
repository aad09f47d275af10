"""First principles along one degree of freedom at a time, the others held at the working point:
slopes of the coupled platform's energy (docs/geometric.md)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from qzs_rig.mechanics.design import Design
from qzs_rig.mechanics.restoring.closed_form import vertical
from qzs_rig.mechanics.restoring.law import Formulas, RestoringLaw, Taylor
from qzs_rig.mechanics.restoring.roots import Root

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
    A, _, _, L0, a, _ = design
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


def bind(rsqrt: Root) -> Formulas:
    """The four projections around a reciprocal square root."""
    return (
        vertical(rsqrt),
        _horizontal(rsqrt),
        _vertical_rotation(rsqrt),
        _horizontal_rotation(rsqrt),
    )


def _vertical_stiffness(design: Design, x: Any) -> Any:
    A, k3, L1, _, a, _ = design
    length = np.sqrt(x * x + a * a)
    return 1.0 + A + (k3 * a * (a * a - x * L1) - A * a * a) / length**3


def _vertical_potential(design: Design, x: Any) -> Any:
    A, k3, L1, _, a, b = design
    length = np.sqrt(x * x + a * a)
    leaf = k3 * a * (length - a + L1 * np.arcsinh(x / a))
    return 0.5 * (1.0 + A) * x * x - A * (length - a) + leaf - b * x


def _horizontal_stiffness(design: Design, x: Any) -> Any:
    A, _, _, _, a, _ = design
    return 1.0 + A - 0.5 * A * a * a / np.sqrt(a * a + x * x) ** 3


def _horizontal_potential(design: Design, x: Any) -> Any:
    A, _, _, _, a, _ = design
    return 0.5 * (1.0 + A) * x * x - 0.5 * A * (np.sqrt(a * a + x * x) - a)


def _vertical_rotation_stiffness(design: Design, theta: Any) -> Any:
    A, _, _, L0, a, _ = design
    R = L0 + a
    length = np.sqrt(a * a + 4.0 * L0 * R * np.sin(0.5 * theta) ** 2)
    bracket = 1.0 - 1.0 / length + HINGE * (1.0 / a - 1.0)
    return A * R * (np.cos(theta) * bracket + np.sin(theta) ** 2 * L0 * R / length**3)


def _vertical_rotation_potential(design: Design, theta: Any) -> Any:
    A, _, _, L0, a, _ = design
    R = L0 + a
    squared = np.sin(0.5 * theta) ** 2
    length = np.sqrt(a * a + 4.0 * L0 * R * squared)
    spring = 0.5 * A * ((length - 1.0) ** 2 - (1.0 - a) ** 2) / L0
    return spring + 2.0 * HINGE * A * R * (1.0 / a - 1.0) * squared


def _horizontal_rotation_stiffness(design: Design, theta: Any) -> Any:
    A, k3, _, L0, a, _ = design
    R, c, s2 = L0 + a, np.cos(theta), np.sin(theta) ** 2
    length = np.sqrt(a * a + 4.0 * L0 * R * np.sin(0.5 * theta) ** 2)
    span, lift = R - L0 * c, R * c - L0
    slope = c * lift - s2 * (R + lift * (L0 * R / length**2 + 2.0 * L0 / span))
    leaf = 0.5 * k3 * a * a * L0 * slope / (length * span * span)
    spring = 0.5 * A * R * (c * (1.0 - 1.0 / length) + s2 * L0 * R / length**3)
    return spring + leaf + c * HINGE * A * R * (1.0 / a - 1.0)


def _horizontal_rotation_potential(design: Design, theta: Any) -> Any:
    A, k3, _, L0, a, _ = design
    R, squared = L0 + a, np.sin(0.5 * theta) ** 2
    length = np.sqrt(a * a + 4.0 * L0 * R * squared)
    spring = 0.25 * A * ((length - 1.0) ** 2 - (1.0 - a) ** 2) / L0
    leaf = 0.5 * k3 * a * a * (length / (R - L0 * np.cos(theta)) - 1.0) / L0
    return spring + leaf + 2.0 * HINGE * A * R * (1.0 / a - 1.0) * squared


STIFFNESSES: Formulas = (
    _vertical_stiffness,
    _horizontal_stiffness,
    _vertical_rotation_stiffness,
    _horizontal_rotation_stiffness,
)
POTENTIALS: Formulas = (
    _vertical_potential,
    _horizontal_potential,
    _vertical_rotation_potential,
    _horizontal_rotation_potential,
)


def taylor(design: Design) -> Taylor:
    """(c1, c2, c3) of c1 w + c2 w² + c3 w³; the vertical's are those of Eq (8)."""
    A, k3, _, L0, a, b = design
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
    bind,
    STIFFNESSES,
    POTENTIALS,
    taylor,
    DOMAIN,
)
