"""Statics of the platform, Eqs (5)-(24): curves, QZS conditions, soft range, load, deviation.

Everything is nondimensional, as in the paper: force / (k1 L20), torque / (k1 L20 L0), motion / L20
or rad, vertical positive downward from the working point.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from qzs_rig.errors import InputError
from qzs_rig.mechanics.restoring.law import Design, RestoringLaw
from qzs_rig.samples import Array
from qzs_rig.units import DOFS

FAR = 10.0
"""Where a search along a law ends: ten suspension springs away."""
GRID = 1e-3
"""Step of such a search; what happens within it is refined by bisection."""


class Curve(NamedTuple):
    """Force and stiffness at x; the force carries the static load, F(0) = `static_load`."""

    x: Array
    force: Array
    stiffness: Array
    static_load: float


class Conditions(NamedTuple):
    """Stiffness at the working point; zero where the condition holds."""

    vertical: float  # (16): 1 + A - A/a + k3
    vertical_rotation: float  # (18): k3 L0
    horizontal_rotation: float  # (19): k3 - A L0
    least_suspension: float  # (17): A must be above a/(1 - a) (erratum E3)


class Deviation(NamedTuple):
    """Largest difference of two laws over |x| <= reach, and the same over the largest force."""

    reach: float
    largest: float
    relative: float


def curve(law: RestoringLaw, design: Design, dof: str, x: Array) -> Curve:
    """The law along one degree of freedom; InputError for a point outside its domain."""
    number = DOFS.index(dof)
    bound = law.domain[number]
    beyond = np.flatnonzero(~(np.abs(x) < bound))
    if beyond.size:
        raise InputError(
            f'{dof} = {x[beyond[0]]:g} is outside the domain of {law.name}; '
            f'give {"numbers" if math.isinf(bound) else f"|x| < {bound:g}"}'
        )
    motion = np.zeros((len(x), len(DOFS)))
    motion[:, number] = x
    load = law.static_load(design)[number]
    force = law.force(design, motion)[:, number] + load
    return Curve(x, force, law.stiffness(design, motion)[:, number], load)


def conditions(design: Design) -> Conditions:
    """Eqs (16)-(19) for a design."""
    A, k3, _, L0, a, _ = design.ratios
    smallest = a / (1.0 - a)
    return Conditions(1.0 + A - A / a + k3, k3 * L0, k3 - A * L0, smallest)


def suspension_for(k3: float, a: float) -> float:
    """A that fulfils (16): (1 + k3) a/(1 - a)."""
    return (1.0 + k3) * a / (1.0 - a)


def triples(design: Design) -> list[Design]:
    """The designs of Figure 9, all else as in `design`: k3 = 0.1, 0.5, 1 with A by (16) and
    L0 = 0.1, 0.3, 0.5."""
    return [
        design.replace(A=suspension_for(k3, design.a), k3=k3, L0=L0)
        for k3, L0 in ((0.1, 0.1), (0.5, 0.3), (1.0, 0.5))
    ]


def soft_range(
    law: RestoringLaw, design: Design, dof: str, tolerance: float
) -> tuple[float, float] | None:
    """The interval around 0 where |K| <= tolerance, None where K(0) already exceeds it.

    Ends that lie beyond the law's domain or FAR are given as that bound.
    """

    def excess(x: Array) -> Array:
        return np.abs(_stiffness(law, design, dof, x)) - tolerance

    if excess(np.zeros(1))[0] > 0:
        return None
    end = min(FAR, math.nextafter(law.domain[DOFS.index(dof)], 0.0))
    low, high = (_first_above(excess, side, end) for side in (-1.0, 1.0))
    return -end if low is None else low, end if high is None else high


def lowest_stiffness(law: RestoringLaw, design: Design, dof: str, reach: float) -> float:
    """Smallest stiffness over |x| <= reach, on a grid of a thousandth of it."""
    return float(_stiffness(law, design, dof, np.linspace(-reach, reach, 2001)).min())


def load_capacity(design: Design, x0: Any) -> Any:
    """(24): load the leaf springs carry at x0 from their relaxed state; saturates at k3 a."""
    return design.k3 * x0 * design.a / np.sqrt(x0 * x0 + design.a**2)


def saturated_load(design: Design) -> float:
    """Where (24) ends for large x0."""
    return float(design.k3 * design.a)


def deviation(
    law: RestoringLaw, reference: RestoringLaw, design: Design, dof: str, reach: float
) -> Deviation:
    """How far `law` is from `reference` over |x| <= reach, both net of the static load."""
    number = DOFS.index(dof)
    motion = np.zeros((2001, len(DOFS)))
    motion[:, number] = np.linspace(-reach, reach, 2001)
    got, wanted = (item.force(design, motion)[:, number] for item in (law, reference))
    largest, size = float(np.abs(got - wanted).max()), float(np.abs(wanted).max())
    return Deviation(reach, largest, largest / size if size else 0.0)


def reach_within(
    law: RestoringLaw, reference: RestoringLaw, design: Design, dof: str, relative: float
) -> float:
    """The largest reach up to which the relative deviation stays within `relative`."""
    end = min(2.0, 0.999 * reference.domain[DOFS.index(dof)])
    reach = 0.0
    for step in np.linspace(end / 200, end, 200):
        if deviation(law, reference, design, dof, float(step)).relative > relative:
            break
        reach = float(step)
    return reach


def equilibrium(law: RestoringLaw, design: Design, load: float) -> float:
    """Where the vertical law comes to rest under `load` beyond the balanced one: F(x) = load.

    The nearest crossing in the direction of the load, as a plate that is let go slowly finds it.
    Raises InputError where the springs cannot hold the load.
    """
    if load == 0.0:
        return 0.0
    side = math.copysign(1.0, load)

    def excess(x: Array) -> Array:
        return side * (_force(law, design, x) - load)

    found = _first_above(excess, side, FAR)
    if found is None:
        raise InputError(
            f'platform.payload_trim loads the springs by {load:g} k1 L20, which law {law.name} '
            'holds nowhere; bring platform.payload_trim nearer to 0'
        )
    return found


def _force(law: RestoringLaw, design: Design, x: Array) -> Array:
    return np.asarray(law.along(0)(design, x))


def _stiffness(law: RestoringLaw, design: Design, dof: str, x: Array) -> Array:
    return np.broadcast_to(law.stiffness_along(DOFS.index(dof))(design, x), x.shape)


def _first_above(function: Callable[[Array], Array], side: float, end: float) -> float | None:
    """First x from 0 towards `side` where `function` exceeds 0: a grid, then bisection to the last
    bit. Every report asks for it, and scipy.optimize takes longer to import than all it checks."""
    grid = np.append(np.arange(0.0, end, GRID), end)
    above = np.flatnonzero(function(side * grid) > 0.0)
    if not above.size:
        return None
    low, high = grid[max(above[0] - 1, 0)], grid[above[0]]
    while low < (middle := 0.5 * (low + high)) < high:
        if function(np.array([side * middle]))[0] > 0.0:
            high = middle
        else:
            low = middle
    return float(side * high)
