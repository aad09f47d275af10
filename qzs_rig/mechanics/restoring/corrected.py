"""The closed form made right: an axisymmetric platform pulls back alike on both sides."""

from __future__ import annotations

from typing import Any

import numpy as np

from qzs_rig.mechanics.design import Design
from qzs_rig.mechanics.restoring import closed_form
from qzs_rig.mechanics.restoring.law import Formulas, RestoringLaw, Taylor
from qzs_rig.mechanics.restoring.roots import Root


def _horizontal(rsqrt: Root) -> Any:
    """Eq (11) with the stretched spring pulling (erratum E4); stiffness at 0 is 2 A a²."""

    def force(design: Any, x: Any) -> Any:
        A, _, L1, _, a, _ = design
        near = rsqrt((a - x) * (a - x) + L1 * L1) - 1.0
        far = rsqrt((a + x) * (a + x) + L1 * L1) - 1.0
        central = 1.0 - L1 * rsqrt(x * x + L1 * L1)
        return A * (near * (a - x) - far * (a + x)) + x * central

    return force


def _horizontal_stiffness(design: Design, x: Any) -> Any:
    A, _, L1, _, a, _ = design
    near = 1.0 / np.sqrt((a - x) * (a - x) + L1 * L1)
    far = 1.0 / np.sqrt((a + x) * (a + x) + L1 * L1)
    central = L1 / np.sqrt(x * x + L1 * L1)
    cubes = near * near * near + far * far * far
    return A * (2.0 - L1 * L1 * cubes) + 1.0 - central * central * central


def _horizontal_potential(design: Design, x: Any) -> Any:
    A, _, L1, _, a, _ = design
    near, far = (np.sqrt((a - s * x) ** 2 + L1 * L1) - 1.0 for s in (1.0, -1.0))
    central = np.sqrt(x * x + L1 * L1) - L1
    return 0.5 * (A * (near * near + far * far) + central * central)


def _horizontal_rotation(rsqrt: Root) -> Any:
    """Odd part of Eq (15) (erratum E7); the origin tips where k3 < A L0."""

    def torque(design: Any, theta: Any) -> Any:
        A, k3, _, L0, _, _ = design
        square = 1.0 - theta * theta
        c = square * rsqrt(square)
        return (k3 - A * L0 * c) * theta * c

    return torque


def _horizontal_rotation_stiffness(design: Design, theta: Any) -> Any:
    A, k3, _, L0, _, _ = design
    square = theta * theta
    leaf = k3 * (1.0 - 2.0 * square) / np.sqrt(1.0 - square)
    return leaf - A * L0 * (1.0 - 3.0 * square)


def _horizontal_rotation_potential(design: Design, theta: Any) -> Any:
    A, k3, _, L0, _, _ = design
    square = theta * theta
    leaf = k3 * (1.0 - np.sqrt(1.0 - square) ** 3) / 3.0
    return leaf - A * L0 * square * (0.5 - square / 4.0)


def bind(rsqrt: Root) -> Formulas:
    """The four corrected laws around a reciprocal square root."""
    return (
        closed_form.vertical(rsqrt),
        _horizontal(rsqrt),
        closed_form.vertical_rotation(rsqrt),
        _horizontal_rotation(rsqrt),
    )


def taylor(design: Design) -> Taylor:
    """Taylor terms; horizontally and in horizontal rotation without the closed form's even ones."""
    A, _, L1, _, a, _ = design
    sideways = (2.0 * A * a**2, 0.0, 1.0 / (2.0 * L1**2) - A * L1**2 * (5.0 * a**2 - 1.0))
    vertical, _, yaw, (c1, _, c3) = closed_form.taylor(design)
    return vertical, sideways, yaw, (c1, 0.0, c3)


CORRECTED = RestoringLaw(
    'corrected',
    'Wang et al. 2022, Eqs (8), (11), (13), (15) with errata E4, E7',
    bind,
    (
        closed_form.vertical_stiffness,
        _horizontal_stiffness,
        closed_form.vertical_rotation_stiffness,
        _horizontal_rotation_stiffness,
    ),
    (
        closed_form.vertical_potential,
        _horizontal_potential,
        closed_form.vertical_rotation_potential,
        _horizontal_rotation_potential,
    ),
    taylor,
    closed_form.DOMAIN,
)
