"""The paper's linear mode: the leaf springs alone, linearised about the working point."""

from __future__ import annotations

from typing import Any

from qzs_rig.mechanics.design import Design
from qzs_rig.mechanics.restoring.closed_form import Sqrt
from qzs_rig.mechanics.restoring.law import Cubic, Formulas, RestoringLaw


def _stiffness_k3(_: Sqrt) -> Any:
    def force(design: Any, w: Any) -> Any:
        return design[1] * w

    return force


def _stiffness_k3_L0(_: Sqrt) -> Any:
    def torque(design: Any, w: Any) -> Any:
        return design[1] * design[3] * w

    return torque


def bind(sqrt: Sqrt) -> Formulas:
    """Leaf terms of Eqs (8), (13), (15) at the working point; sideways the leaf's own k3."""
    k3 = _stiffness_k3(sqrt)
    return k3, k3, _stiffness_k3_L0(sqrt), k3


def cubic(design: Design) -> Cubic:
    """k3 for translations and horizontal rotation, k3 L0 for vertical rotation."""
    return (design.k3, 0.0), (design.k3, 0.0), (design.k3 * design.L0, 0.0), (design.k3, 0.0)


LINEAR = RestoringLaw(
    'linear', 'Wang et al. 2022, section 5 (linear mode), erratum E10', bind, cubic
)
