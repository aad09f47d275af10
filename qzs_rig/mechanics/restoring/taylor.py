"""The closed form to third order about the working point, expanded right (errata E5, E6)."""

from __future__ import annotations

from typing import Any

from qzs_rig.mechanics.restoring import closed_form
from qzs_rig.mechanics.restoring.polynomial import polynomial


def vertical(design: Any, x: Any) -> Any:
    """Eq (20) less the payload's weight b."""
    A, k3, _, _, a, b = design
    square = 2.0 * a * a
    return ((A / (square * a) - k3 / square) * x * x - b / square * x + 1.0 + A - A / a + k3) * x


def horizontal(design: Any, x: Any) -> Any:
    """Eq (21) with L1² in the denominator."""
    A, _, L1, _, a, _ = design
    return (x / (2.0 * L1 * L1) - 3.0 * A * a * L1 * L1) * x * x


def _vertical_rotation(design: Any, theta: Any) -> Any:
    """Eq (22) with L0³ (erratum E5)."""
    A, k3, _, L0, _, _ = design
    s = L0 * theta
    return (k3 - (A / 2.0 + k3) * s * s) * s


def _horizontal_rotation(design: Any, theta: Any) -> Any:
    """Eq (23) with the A L0 theta³/2 that it drops (erratum E6)."""
    A, k3, _, L0, _, _ = design
    tip = A * L0 - k3
    return ((A * L0 - k3 / 2.0) * theta * theta + tip * theta - tip) * theta


TAYLOR = polynomial(
    'taylor',
    'Wang et al. 2022, Eqs (20)-(23) with errata E5, E6',
    (vertical, horizontal, _vertical_rotation, _horizontal_rotation),
    closed_form.taylor,
    weighted=True,
)
