"""The paper's full laws, Eqs (8), (11), (13), (15), as printed (vertical with the erratum E2)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from qzs_rig.mechanics.design import Design
from qzs_rig.mechanics.restoring.law import Formulas, RestoringLaw, Taylor
from qzs_rig.mechanics.restoring.roots import Root

DOMAIN = (math.inf, math.inf, math.inf, 1.0)
"""Eq (15) takes sqrt(1 - theta²) for the cosine."""


def vertical(rsqrt: Root) -> Any:
    """Eq (8) less the payload's weight b."""

    def force(design: Any, x: Any) -> Any:
        A, k3, L1, _, a, b = design
        r = rsqrt(x * x + a * a)
        return x + A * x * (1.0 - r) + k3 * (a * r) * (x + L1) - b

    return force


def vertical_stiffness(design: Design, x: Any) -> Any:
    """Eq (9) with exponent 3/2 and minus before x L1 (erratum E1)."""
    A, k3, L1, _, a, _ = design
    length = np.sqrt(x * x + a * a)
    leaf = k3 * a * (a * a - x * L1)
    return 1.0 + A + (leaf - A * a * a) / (length * length * length)


def vertical_potential(design: Design, x: Any) -> Any:
    """Central spring, suspension, leaf springs and weight of Eq (8)."""
    A, k3, L1, _, a, b = design
    length = np.sqrt(x * x + a * a)
    leaf = k3 * a * (length - a + L1 * np.arcsinh(x / a))
    return 0.5 * (1.0 + A) * x * x - A * (length - a) + leaf - b * x


def vertical_rotation(rsqrt: Root) -> Any:
    """Eq (13)."""

    def torque(design: Any, theta: Any) -> Any:
        A, k3, _, L0, _, _ = design
        s = L0 * theta
        q = s * s + 1.0
        return -A * s * (1.0 - rsqrt(q)) + k3 * s / q

    return torque


def vertical_rotation_stiffness(design: Design, theta: Any) -> Any:
    """Slope of Eq (13)."""
    A, k3, _, L0, _, _ = design
    s = L0 * theta
    q = s * s + 1.0
    return L0 * (A * (1.0 / (q * np.sqrt(q)) - 1.0) + k3 * (1.0 - s * s) / (q * q))


def vertical_rotation_potential(design: Design, theta: Any) -> Any:
    """Suspension and leaf springs of Eq (13)."""
    A, k3, _, L0, _, _ = design
    s = L0 * theta
    stretch = np.sqrt(s * s + 1.0) - 1.0
    return 0.5 * (k3 * np.log1p(s * s) - A * stretch * stretch) / L0


def _horizontal(rsqrt: Root) -> Any:
    """Eq (11); its even part is wrong (erratum E4): the plate slides into a false well."""

    def force(design: Any, x: Any) -> Any:
        A, _, L1, _, a, _ = design
        near = rsqrt((a - x) * (a - x) + L1 * L1)
        far = rsqrt((a + x) * (a + x) + L1 * L1)
        slope = 1.0 - L1 * rsqrt(x * x + L1 * L1) - A * (near - far)
        return A * a * (near + far - 2.0) + x * slope

    return force


def _horizontal_stiffness(design: Design, x: Any) -> Any:
    A, _, L1, _, a, _ = design
    near = 1.0 / np.sqrt((a - x) * (a - x) + L1 * L1)
    far = 1.0 / np.sqrt((a + x) * (a + x) + L1 * L1)
    central = L1 / np.sqrt(x * x + L1 * L1)
    cubes = far * far * far - near * near * near
    return A * L1 * L1 * cubes + 1.0 - central * central * central


def _horizontal_potential(design: Design, x: Any) -> Any:
    A, _, L1, _, a, _ = design
    near, far = (np.sqrt((a - s * x) ** 2 + L1 * L1) for s in (1.0, -1.0))
    central = np.sqrt(x * x + L1 * L1) - L1
    return A * (far - near - 2.0 * a * x) + 0.5 * central * central


def _horizontal_rotation(rsqrt: Root) -> Any:
    """Eq (15); not odd (erratum E7)."""

    def torque(design: Any, theta: Any) -> Any:
        A, k3, _, L0, _, _ = design
        square = 1.0 - theta * theta
        c = square * rsqrt(square)
        return (A * L0 * c - k3) * theta * (theta - c)

    return torque


def _horizontal_rotation_stiffness(design: Design, theta: Any) -> Any:
    A, k3, _, L0, _, _ = design
    square = theta * theta
    c = np.sqrt(1.0 - square)
    suspension = theta * (2.0 * c - square / c) - 1.0 + 3.0 * square
    return A * L0 * suspension + k3 * ((1.0 - 2.0 * square) / c - 2.0 * theta)


def _horizontal_rotation_potential(design: Design, theta: Any) -> Any:
    A, k3, _, L0, _, _ = design
    square = theta * theta
    c = np.sqrt(1.0 - square)
    even = (np.arcsin(theta) - theta * c * (1.0 - 2.0 * square)) / 8.0
    suspension = even - square / 2.0 + square * square / 4.0
    return A * L0 * suspension + k3 * (1.0 - c**3 - theta**3) / 3.0


def bind(rsqrt: Root) -> Formulas:
    """The four printed laws around a reciprocal square root."""
    return (
        vertical(rsqrt),
        _horizontal(rsqrt),
        vertical_rotation(rsqrt),
        _horizontal_rotation(rsqrt),
    )


def taylor(design: Design) -> Taylor:
    """Third-order expansion of Eqs (8), (11), (13), (15), done right (errata E5, E6)."""
    A, k3, L1, L0, a, b = design
    tip = A * L0 - k3
    return (
        (1.0 + A - A / a + k3, -b / (2.0 * a**2), A / (2.0 * a**3) - k3 / (2.0 * a**2)),
        (0.0, -3.0 * A * a * L1**2, 1.0 / (2.0 * L1**2)),
        (k3 * L0, 0.0, -(A / 2.0 + k3) * L0**3),
        (-tip, tip, A * L0 - k3 / 2.0),
    )


CLOSED_FORM = RestoringLaw(
    'closed_form',
    'Wang et al. 2022, Eqs (8), (11), (13), (15)',
    bind,
    (
        vertical_stiffness,
        _horizontal_stiffness,
        vertical_rotation_stiffness,
        _horizontal_rotation_stiffness,
    ),
    (
        vertical_potential,
        _horizontal_potential,
        vertical_rotation_potential,
        _horizontal_rotation_potential,
    ),
    taylor,
    DOMAIN,
)
