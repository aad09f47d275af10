"""The paper's full laws, Eqs (8), (11), (13), (15): as printed (vertical with the erratum E2), and
made right, since an axisymmetric platform pulls back alike on both sides."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from qzs_rig.mechanics.restoring.law import Design, RestoringLaw, Root, Taylor

DOMAIN = (math.inf, math.inf, math.inf, 1.0)
"""Eq (15) takes sqrt(1 - theta²) for the cosine."""


def vertical(rsqrt: Root) -> Any:
    """Eq (8) less the payload's weight b."""

    def force(design: Any, x: Any) -> Any:
        A, k3, L1, _, a, b = design
        r = rsqrt(x * x + a * a)
        return x + A * x * (1.0 - r) + k3 * (a * r) * (x + L1) - b

    return force


def vertical_stiffness(design: Any, x: Any) -> Any:
    """Eq (9) with exponent 3/2 and minus before x L1 (erratum E1)."""
    A, k3, L1, _, a, _ = design
    length = np.sqrt(x * x + a * a)
    leaf = k3 * a * (a * a - x * L1)
    return 1.0 + A + (leaf - A * a * a) / (length * length * length)


def _vertical_rotation(rsqrt: Root) -> Any:
    """Eq (13)."""

    def torque(design: Any, theta: Any) -> Any:
        A, k3, _, L0, _, _ = design
        s = L0 * theta
        q = s * s + 1.0
        return -A * s * (1.0 - rsqrt(q)) + k3 * s / q

    return torque


def _vertical_rotation_stiffness(design: Any, theta: Any) -> Any:
    """Slope of Eq (13)."""
    A, k3, _, L0, _, _ = design
    s = L0 * theta
    q = s * s + 1.0
    return L0 * (A * (1.0 / (q * np.sqrt(q)) - 1.0) + k3 * (1.0 - s * s) / (q * q))


def _horizontal(rsqrt: Root) -> Any:
    """Eq (11); its even part is wrong (erratum E4): the plate slides into a false well."""

    def force(design: Any, x: Any) -> Any:
        A, _, L1, _, a, _ = design
        near = rsqrt((a - x) * (a - x) + L1 * L1)
        far = rsqrt((a + x) * (a + x) + L1 * L1)
        slope = 1.0 - L1 * rsqrt(x * x + L1 * L1) - A * (near - far)
        return A * a * (near + far - 2.0) + x * slope

    return force


def _horizontal_stiffness(design: Any, x: Any) -> Any:
    A, _, L1, _, a, _ = design
    near = 1.0 / np.sqrt((a - x) * (a - x) + L1 * L1)
    far = 1.0 / np.sqrt((a + x) * (a + x) + L1 * L1)
    central = L1 / np.sqrt(x * x + L1 * L1)
    cubes = far * far * far - near * near * near
    return A * L1 * L1 * cubes + 1.0 - central * central * central


def _horizontal_rotation(rsqrt: Root) -> Any:
    """Eq (15); not odd (erratum E7)."""

    def torque(design: Any, theta: Any) -> Any:
        A, k3, _, L0, _, _ = design
        square = 1.0 - theta * theta
        c = square * rsqrt(square)
        return (A * L0 * c - k3) * theta * (theta - c)

    return torque


def _horizontal_rotation_stiffness(design: Any, theta: Any) -> Any:
    A, k3, _, L0, _, _ = design
    square = theta * theta
    c = np.sqrt(1.0 - square)
    suspension = theta * (2.0 * c - square / c) - 1.0 + 3.0 * square
    return A * L0 * suspension + k3 * ((1.0 - 2.0 * square) / c - 2.0 * theta)


def _odd_horizontal(rsqrt: Root) -> Any:
    """Eq (11) with the stretched spring pulling (erratum E4); stiffness at 0 is 2 A a²."""

    def force(design: Any, x: Any) -> Any:
        A, _, L1, _, a, _ = design
        near = rsqrt((a - x) * (a - x) + L1 * L1) - 1.0
        far = rsqrt((a + x) * (a + x) + L1 * L1) - 1.0
        central = 1.0 - L1 * rsqrt(x * x + L1 * L1)
        return A * (near * (a - x) - far * (a + x)) + x * central

    return force


def _odd_horizontal_stiffness(design: Any, x: Any) -> Any:
    A, _, L1, _, a, _ = design
    near = 1.0 / np.sqrt((a - x) * (a - x) + L1 * L1)
    far = 1.0 / np.sqrt((a + x) * (a + x) + L1 * L1)
    central = L1 / np.sqrt(x * x + L1 * L1)
    cubes = near * near * near + far * far * far
    return A * (2.0 - L1 * L1 * cubes) + 1.0 - central * central * central


def _odd_horizontal_rotation(rsqrt: Root) -> Any:
    """Odd part of Eq (15) (erratum E7); the origin tips where k3 < A L0."""

    def torque(design: Any, theta: Any) -> Any:
        A, k3, _, L0, _, _ = design
        square = 1.0 - theta * theta
        c = square * rsqrt(square)
        return (k3 - A * L0 * c) * theta * c

    return torque


def _odd_horizontal_rotation_stiffness(design: Any, theta: Any) -> Any:
    A, k3, _, L0, _, _ = design
    square = theta * theta
    leaf = k3 * (1.0 - 2.0 * square) / np.sqrt(1.0 - square)
    return leaf - A * L0 * (1.0 - 3.0 * square)


def taylor(design: Design) -> Taylor:
    """Third-order expansion of Eqs (8), (11), (13), (15), done right (errata E5, E6)."""
    A, k3, L1, L0, a, b = design.ratios
    tip = A * L0 - k3
    return (
        (1.0 + A - A / a + k3, -b / (2.0 * a**2), A / (2.0 * a**3) - k3 / (2.0 * a**2)),
        (0.0, -3.0 * A * a * L1**2, 1.0 / (2.0 * L1**2)),
        (k3 * L0, 0.0, -(A / 2.0 + k3) * L0**3),
        (-tip, tip, A * L0 - k3 / 2.0),
    )


def _odd_taylor(design: Design) -> Taylor:
    """Taylor terms; horizontally and in horizontal rotation without the closed form's even ones."""
    A, _, L1, _, a, _ = design.ratios
    sideways = (2.0 * A * a**2, 0.0, 1.0 / (2.0 * L1**2) - A * L1**2 * (5.0 * a**2 - 1.0))
    vertical, _, yaw, (c1, _, c3) = taylor(design)
    return vertical, sideways, yaw, (c1, 0.0, c3)


CLOSED_FORM = RestoringLaw(
    'closed_form',
    'Wang et al. 2022, Eqs (8), (11), (13), (15)',
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
    odd=('vertical_rotation',),
)

CORRECTED = RestoringLaw(
    'corrected',
    'Wang et al. 2022, Eqs (8), (11), (13), (15) with errata E4, E7',
    _odd_taylor,
    (
        vertical,
        _odd_horizontal,
        _vertical_rotation,
        _odd_horizontal_rotation,
    ),
    (
        vertical_stiffness,
        _odd_horizontal_stiffness,
        _vertical_rotation_stiffness,
        _odd_horizontal_rotation_stiffness,
    ),
    DOMAIN,
    odd=('horizontal', 'vertical_rotation', 'horizontal_rotation'),
)
