"""The paper's full laws, Eqs (8), (11), (13), (15), as printed (vertical with the erratum E2)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from qzs_rig.mechanics.design import Design
from qzs_rig.mechanics.restoring.law import Cubic, Formulas, RestoringLaw

Sqrt = Callable[[Any], Any]


def vertical(sqrt: Sqrt) -> Any:
    """Eq (8) less the payload's weight b."""

    def force(design: Any, x: Any) -> Any:
        A, k3, L1, _, a, b = design
        length = sqrt(x * x + a * a)
        return x + A * x * (1.0 - 1.0 / length) + k3 * (a / length) * (x + L1) - b

    return force


def vertical_rotation(sqrt: Sqrt) -> Any:
    """Eq (13)."""

    def torque(design: Any, theta: Any) -> Any:
        A, k3, _, L0, _, _ = design
        s = L0 * theta
        q = s * s + 1.0
        return -A * s * (1.0 - 1.0 / sqrt(q)) + k3 * s / q

    return torque


def _horizontal(sqrt: Sqrt) -> Any:
    """Eq (11); its even part is wrong (erratum E4): the plate slides into a false well."""

    def force(design: Any, x: Any) -> Any:
        A, _, L1, _, a, _ = design
        near = 1.0 / sqrt((a - x) * (a - x) + L1 * L1)
        far = 1.0 / sqrt((a + x) * (a + x) + L1 * L1)
        slope = 1.0 - L1 / sqrt(x * x + L1 * L1) - A * (near - far)
        return A * a * (near + far - 2.0) + x * slope

    return force


def _horizontal_rotation(sqrt: Sqrt) -> Any:
    """Eq (15); not odd (erratum E7)."""

    def torque(design: Any, theta: Any) -> Any:
        A, k3, _, L0, _, _ = design
        c = sqrt(1.0 - theta * theta)
        return (A * L0 * c - k3) * theta * (theta - c)

    return torque


def bind(sqrt: Sqrt) -> Formulas:
    """The four printed laws around a square root."""
    return vertical(sqrt), _horizontal(sqrt), vertical_rotation(sqrt), _horizontal_rotation(sqrt)


def cubic(design: Design) -> Cubic:
    """Odd Taylor terms of Eqs (8), (11), (13), (15)."""
    A, k3, L1, L0, a, _ = design
    return (
        (1.0 + A - A / a + k3, A / (2.0 * a**3) - k3 / (2.0 * a**2)),
        (0.0, 1.0 / (2.0 * L1**2)),
        (k3 * L0, -(A / 2.0 + k3) * L0**3),
        (k3 - A * L0, A * L0 - k3 / 2.0),
    )


CLOSED_FORM = RestoringLaw(
    'closed_form', 'Wang et al. 2022, Eqs (8), (11), (13), (15)', bind, cubic
)
