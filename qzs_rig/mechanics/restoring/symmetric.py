"""The law that the paper's own harmonic balance (29) solves: odd cubic terms of Eq (27)."""

from __future__ import annotations

from typing import Any

from qzs_rig.mechanics.design import Design
from qzs_rig.mechanics.restoring.closed_form import Sqrt
from qzs_rig.mechanics.restoring.law import Cubic, Formulas, RestoringLaw


def _vertical(_: Sqrt) -> Any:
    def force(design: Any, w: Any) -> Any:
        A, k3, _, _, a, _ = design
        c1 = 1.0 + A - A / a + k3
        c3 = A / (2.0 * a * a * a) - k3 / (2.0 * a * a)
        return (c1 + c3 * w * w) * w

    return force


def _horizontal(_: Sqrt) -> Any:
    def force(design: Any, w: Any) -> Any:
        L1 = design[2]
        return w * w * w / (2.0 * L1 * L1)

    return force


def _vertical_rotation(_: Sqrt) -> Any:
    def torque(design: Any, w: Any) -> Any:
        A, k3, _, L0, _, _ = design
        return (k3 * L0 - (A * L0 * L0 * L0 / 2.0 + k3 * L0) * w * w) * w

    return torque


def _horizontal_rotation(_: Sqrt) -> Any:
    def torque(design: Any, w: Any) -> Any:
        A, k3, _, L0, _, _ = design
        return (A * L0 - k3) * (0.5 * w * w - 1.0) * w

    return torque


def bind(sqrt: Sqrt) -> Formulas:
    """The four cubic laws; they need no square root."""
    return _vertical(sqrt), _horizontal(sqrt), _vertical_rotation(sqrt), _horizontal_rotation(sqrt)


def cubic(design: Design) -> Cubic:
    """d3, d1; 0, d5; d6, d7; -d8, d8/2 of Eq (27)."""
    A, k3, L1, L0, a, _ = design
    d8 = A * L0 - k3
    return (
        (1.0 + A - A / a + k3, A / (2.0 * a**3) - k3 / (2.0 * a**2)),
        (0.0, 1.0 / (2.0 * L1**2)),
        (k3 * L0, -(A * L0**3 / 2.0 + k3 * L0)),
        (-d8, d8 / 2.0),
    )


SYMMETRIC = RestoringLaw('symmetric', 'Wang et al. 2022, Eq (27), odd terms', bind, cubic)
