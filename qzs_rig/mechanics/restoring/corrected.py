"""The closed form made right: an axisymmetric platform pulls back alike on both sides."""

from __future__ import annotations

from typing import Any

from qzs_rig.mechanics.design import Design
from qzs_rig.mechanics.restoring.closed_form import Sqrt, vertical, vertical_rotation
from qzs_rig.mechanics.restoring.closed_form import cubic as closed_form_cubic
from qzs_rig.mechanics.restoring.law import Cubic, Formulas, RestoringLaw


def _horizontal(sqrt: Sqrt) -> Any:
    """Eq (11) with the stretched spring pulling (erratum E4); stiffness at 0 is 2 A a²."""

    def force(design: Any, x: Any) -> Any:
        A, _, L1, _, a, _ = design
        near = 1.0 / sqrt((a - x) * (a - x) + L1 * L1) - 1.0
        far = 1.0 / sqrt((a + x) * (a + x) + L1 * L1) - 1.0
        central = 1.0 - L1 / sqrt(x * x + L1 * L1)
        return A * (near * (a - x) - far * (a + x)) + x * central

    return force


def _horizontal_rotation(sqrt: Sqrt) -> Any:
    """Odd part of Eq (15) (erratum E7); the origin tips where k3 < A L0."""

    def torque(design: Any, theta: Any) -> Any:
        A, k3, _, L0, _, _ = design
        c = sqrt(1.0 - theta * theta)
        return (k3 - A * L0 * c) * theta * c

    return torque


def bind(sqrt: Sqrt) -> Formulas:
    """The four corrected laws around a square root."""
    return vertical(sqrt), _horizontal(sqrt), vertical_rotation(sqrt), _horizontal_rotation(sqrt)


def cubic(design: Design) -> Cubic:
    """Odd Taylor terms; only the horizontal ones differ from the closed form."""
    A, _, L1, _, a, _ = design
    horizontal = (2.0 * A * a**2, 1.0 / (2.0 * L1**2) - A * L1**2 * (5.0 * a**2 - 1.0))
    vertical, _, yaw, pitch = closed_form_cubic(design)
    return vertical, horizontal, yaw, pitch


CORRECTED = RestoringLaw(
    'corrected', 'Wang et al. 2022, Eqs (8), (11), (13), (15) with errata E4, E7', bind, cubic
)
