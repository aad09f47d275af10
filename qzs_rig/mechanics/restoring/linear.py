"""The paper's linear mode: the leaf springs alone, linearised about the working point."""

from __future__ import annotations

from typing import Any

from qzs_rig.mechanics.design import Design
from qzs_rig.mechanics.restoring.law import Taylor
from qzs_rig.mechanics.restoring.polynomial import polynomial


def _k3(design: Any, w: Any) -> Any:
    return design[1] * w


def _k3_L0(design: Any, w: Any) -> Any:
    return design[1] * design[3] * w


def taylor(design: Design) -> Taylor:
    """Leaf terms of Eqs (8), (13), (15) at the working point; sideways the leaf's own k3."""
    k3 = (design.k3, 0.0, 0.0)
    return k3, k3, (design.k3 * design.L0, 0.0, 0.0), k3


LINEAR = polynomial(
    'linear',
    'Wang et al. 2022, section 5 (linear mode), erratum E10',
    (_k3, _k3, _k3_L0, _k3),
    taylor,
    weighted=False,
)
