"""Where a payload too heavy or too light comes to rest under a restoring law."""

from __future__ import annotations

import math

from qzs_rig.errors import InputError
from qzs_rig.mechanics.design import Design
from qzs_rig.mechanics.restoring.law import RestoringLaw

FURTHEST = 8.0
"""Displacement over L20 beyond which nothing is looked for."""
FIRST = 2.0**-20
"""First one looked at: a quasi-zero stiffness moves far under little."""


def trimmed(law: RestoringLaw, design: Design, load: float) -> float:
    """Nondimensional vertical displacement, positive downward, at which `law` balances `load`.

    The nearest one on the side to which the load pushes, by bisection to the last bit: at a
    quasi-zero stiffness Newton's method has no slope to follow. Raises InputError where there is
    none.
    """
    formula = law.bind(math.sqrt)[0]

    def excess(x: float) -> float:
        return abs(load) - side * float(formula(design, side * x))

    side = math.copysign(1.0, load)
    near, far = 0.0, FIRST
    while excess(far) > 0.0:
        near, far = far, 1.25 * far
        if far > FURTHEST:
            raise InputError(
                f'law {law.name} cannot hold a load of {load:.4g} k1 L20 beside the balanced '
                'payload; bring platform.balanced_mass nearer to platform.m'
            )
    while near < (middle := 0.5 * (near + far)) < far:
        near, far = (middle, far) if excess(middle) > 0.0 else (near, middle)
    return side * far
