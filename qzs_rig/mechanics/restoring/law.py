"""What a restoring law is: formulas that serve scalars, arrays and compiled code alike."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from qzs_rig.mechanics.design import Design
from qzs_rig.mechanics.restoring import bulk
from qzs_rig.mechanics.restoring.roots import Root, reciprocal
from qzs_rig.samples import Array

Formula = Callable[[Design, Any], Any]
"""Net nondimensional force (or torque) at the relative motion w of one degree of freedom; the
payload's weight is balanced, so a law that is QZS vanishes at w = 0. Translations are in units of
L20 and, as in the paper, positive downward for `vertical`; rotations are in rad. Stiffness and
potential are formulas too: slope and integral of the force, the potential zero at w = 0."""

Formulas = tuple[Formula, Formula, Formula, Formula]
Cubic = tuple[tuple[float, float], ...]
Taylor = tuple[tuple[float, float, float], ...]
ANYWHERE = (math.inf,) * 4


@dataclass(frozen=True)
class RestoringLaw:
    """One family of force and torque laws, in the order of DOFS.

    `around(rsqrt)` returns the four forces around a reciprocal square root (see roots), of which
    compiled code has a fast one; `stiffnesses` and `potentials` are numpy's. `taylor(design)`
    gives (c1, c2, c3) of c1 w + c2 w² + c3 w³ for each degree of freedom. The law holds for
    |w| < `domain`. `weighted`: the source's vertical law carries the payload, F(0) = b; here it is
    taken off.
    `cubic_only`: the forces are nothing but the cubics of `taylor`.
    """

    name: str
    source: str
    around: Callable[[Root], Formulas]
    stiffnesses: Formulas
    potentials: Formulas
    taylor: Callable[[Design], Taylor]
    domain: tuple[float, ...] = ANYWHERE
    weighted: bool = True
    cubic_only: bool = False

    def bind(self, sqrt: Root) -> Formulas:
        """The four forces by a square root: math's, numpy's or cmath's."""
        return self.around(reciprocal(sqrt))

    def force(self, design: Design, w: Array) -> Array:
        """Force at w (..., 4) -> (..., 4), nondimensional, net of the static load.

        Many points are shared out to compiled threads where numba is installed, the same bits.
        """
        return bulk.evaluated(self.around, design, w)

    def stiffness(self, design: Design, w: Array) -> Array:
        """Slope of `force` at w (..., 4) -> (..., 4)."""
        return np.stack([k(design, w[..., n]) for n, k in enumerate(self.stiffnesses)], axis=-1)

    def potential(self, design: Design, w: Array) -> Array:
        """Integral of `force` from 0 to w (..., 4) -> (..., 4); over k1 L20² for translations and
        over k1 L20 L0 for rotations it is an energy."""
        return np.stack([v(design, w[..., n]) for n, v in enumerate(self.potentials)], axis=-1)

    def cubic(self, design: Design, rest: float = 0.0) -> Cubic:
        """(c1, c3) of the odd part c1 w + c3 w³, which single-term theory uses, the vertical one
        about w = `rest`."""
        vertical, *others = ((c1, c3) for c1, _, c3 in self.taylor(design))
        if rest:
            # Cauchy's integral, exact to rounding: the laws are analytic within a of the real axis
            turn = 0.2 * design.a * np.exp(2j * np.pi * np.arange(64) / 64)
            force = self.bind(np.sqrt)[0](design, rest + turn)
            c1, c3 = (float(np.mean(force / turn**order).real) for order in (1, 3))
            vertical = (c1, c3)
        return vertical, *others

    def static_load(self, design: Design) -> tuple[float, ...]:
        """What the source's law is at w = 0, balanced by the payload's weight: b or nothing."""
        return (design.b if self.weighted else 0.0, 0.0, 0.0, 0.0)
