"""Laws of third order: slope and integral follow from the coefficients."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from qzs_rig.mechanics.design import Design
from qzs_rig.mechanics.restoring.law import Formula, Formulas, RestoringLaw, Taylor


def polynomial(
    name: str,
    source: str,
    forces: Formulas,
    taylor: Callable[[Design], Taylor],
    *,
    weighted: bool,
) -> RestoringLaw:
    """A law whose `forces` are c1 w + c2 w² + c3 w³ with the coefficients of `taylor(design)`.

    The forces are written out once more because compiled code cannot look into `taylor`.
    """
    numbers = range(4)
    return RestoringLaw(
        name,
        source,
        lambda _: forces,
        _four([_stiffness(taylor, dof) for dof in numbers]),
        _four([_potential(taylor, dof) for dof in numbers]),
        taylor,
        weighted=weighted,
        cubic_only=True,
    )


def cubic_force(coefficients: Any, w: Any) -> Any:
    """c1 w + c2 w² + c3 w³; one formula, and one kernel, for all of these laws."""
    c1, c2, c3 = coefficients[0], coefficients[1], coefficients[2]
    return (c1 + (c2 + c3 * w) * w) * w


def cubic_stiffness(coefficients: Any, w: Any) -> Any:
    """Slope of `cubic_force`."""
    c1, c2, c3 = coefficients[0], coefficients[1], coefficients[2]
    return c1 + (2.0 * c2 + 3.0 * c3 * w) * w


def _stiffness(taylor: Callable[[Design], Taylor], dof: int) -> Formula:
    def stiffness(design: Design, w: Any) -> Any:
        return cubic_stiffness(taylor(design)[dof], w)

    return stiffness


def _potential(taylor: Callable[[Design], Taylor], dof: int) -> Formula:
    def potential(design: Design, w: Any) -> Any:
        c1, c2, c3 = taylor(design)[dof]
        return (c1 / 2.0 + (c2 / 3.0 + c3 / 4.0 * w) * w) * w * w

    return potential


def _four(formulas: list[Formula]) -> Formulas:
    vertical, horizontal, vertical_rotation, horizontal_rotation = formulas
    return vertical, horizontal, vertical_rotation, horizontal_rotation
