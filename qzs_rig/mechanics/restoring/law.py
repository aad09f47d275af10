"""What a restoring law is: four formulas that serve scalars, arrays and compiled code alike."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from qzs_rig.mechanics.design import Design
from qzs_rig.timehistory import Array

Formula = Callable[[Design, Any], Any]
"""Net nondimensional force (or torque) at the relative motion w of one degree of freedom; the
payload's weight is balanced, so a law that is QZS vanishes at w = 0. Translations are in units of
L20 and, as in the paper, positive downward for `vertical`; rotations are in rad."""

Formulas = tuple[Formula, Formula, Formula, Formula]
Cubic = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class RestoringLaw:
    """One family of force and torque laws, in the order of DOFS.

    `bind(sqrt)` returns the four formulas around a square root (math.sqrt, numpy.sqrt or a
    compiled one). `cubic(design)` gives (c1, c3) of the odd part c1 w + c3 w³ for each degree of
    freedom, which single-term theory uses.
    """

    name: str
    source: str
    bind: Callable[[Callable[[Any], Any]], Formulas]
    cubic: Callable[[Design], Cubic]

    def force(self, design: Design, w: Array) -> Array:
        """Force at w (..., 4) -> (..., 4), nondimensional, net of the static load."""
        formulas = self.bind(np.sqrt)
        return np.stack(
            [formula(design, w[..., dof]) for dof, formula in enumerate(formulas)], axis=-1
        )
