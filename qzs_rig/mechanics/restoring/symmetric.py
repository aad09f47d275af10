"""The law that the paper's own harmonic balance (29) solves: odd cubic terms of Eq (27)."""

from __future__ import annotations

from typing import Any

from qzs_rig.mechanics.design import Design
from qzs_rig.mechanics.restoring import printed
from qzs_rig.mechanics.restoring.law import Taylor
from qzs_rig.mechanics.restoring.polynomial import polynomial


def _vertical(design: Any, w: Any) -> Any:
    A, k3, _, _, a, _ = design
    c1 = 1.0 + A - A / a + k3
    c3 = A / (2.0 * a * a * a) - k3 / (2.0 * a * a)
    return (c1 + c3 * w * w) * w


def _horizontal(design: Any, w: Any) -> Any:
    L1 = design[2]
    return w * w * w / (2.0 * L1 * L1)


def _horizontal_rotation(design: Any, w: Any) -> Any:
    A, k3, _, L0, _, _ = design
    return (A * L0 - k3) * (0.5 * w * w - 1.0) * w


def taylor(design: Design) -> Taylor:
    """d3, d1; d5; d6, d7; -d8, d8/2 of Eq (27)."""
    vertical, horizontal, yaw, pitch = ((c1, 0.0, c3) for c1, _, c3 in printed.taylor(design))
    return vertical, horizontal, yaw, pitch


SYMMETRIC = polynomial(
    'symmetric',
    'Wang et al. 2022, Eq (27), odd terms',
    (_vertical, _horizontal, printed.vertical_rotation, _horizontal_rotation),
    taylor,
    weighted=False,
)
