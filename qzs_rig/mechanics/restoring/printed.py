"""Eq (27) with d1…d8 as printed, less the constant b that the payload balances (erratum E18)."""

from __future__ import annotations

from typing import Any, NamedTuple

from qzs_rig.mechanics.design import Design
from qzs_rig.mechanics.restoring import taylor as right
from qzs_rig.mechanics.restoring.law import Taylor
from qzs_rig.mechanics.restoring.polynomial import polynomial


class Coefficients(NamedTuple):
    """d1…d8 below Eq (27)."""

    d1: float
    d2: float
    d3: float
    d4: float
    d5: float
    d6: float
    d7: float
    d8: float


def coefficients(design: Design) -> Coefficients:
    """d1…d8 of a design, as printed."""
    A, k3, L1, L0, a, b = design
    return Coefficients(
        d1=A / (2.0 * a**3) - k3 / (2.0 * a**2),
        d2=-b / (2.0 * a**2),
        d3=A + 1.0 - A / a + k3,
        d4=-3.0 * A * a + 3.0 * A * a**3,
        d5=1.0 / (2.0 * L1**2),
        d6=k3 * L0,
        d7=-A * L0**3 / 2.0 - k3 * L0,
        d8=A * L0 - k3,
    )


def vertical_rotation(design: Any, theta: Any) -> Any:
    """d6 w + d7 w³."""
    A, k3, _, L0, _, _ = design
    return (k3 * L0 - (A * L0 * L0 * L0 / 2.0 + k3 * L0) * theta * theta) * theta


def _horizontal_rotation(design: Any, theta: Any) -> Any:
    """d8 (-w + w² + w³/2)."""
    A, k3, _, L0, _, _ = design
    return (A * L0 - k3) * ((0.5 * theta + 1.0) * theta - 1.0) * theta


def taylor(design: Design) -> Taylor:
    """The coefficients, in the order of powers."""
    d = coefficients(design)
    return (
        (d.d3, d.d2, d.d1),
        (0.0, d.d4, d.d5),
        (d.d6, 0.0, d.d7),
        (-d.d8, d.d8, d.d8 / 2.0),
    )


PRINTED = polynomial(
    'printed',
    'Wang et al. 2022, Eq (27)',
    (right.vertical, right.horizontal, vertical_rotation, _horizontal_rotation),
    taylor,
    weighted=True,
)
