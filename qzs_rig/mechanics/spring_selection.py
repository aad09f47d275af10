"""Springs to order: standard wire and coils, or a leaf, for a wanted rate in an envelope."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from qzs_rig.errors import InputError
from qzs_rig.mechanics.springs import ENDS, Helical, Leaf

WIRES_MM = (
    *(0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8, 1.9),
    *(2.0, 2.1, 2.25, 2.4, 2.5, 2.6, 2.8, 3.0, 3.2, 3.4, 3.6, 3.8, 4.0, 4.25, 4.5, 4.75),
    *(5.0, 5.3, 5.6, 6.0, 6.3, 6.5, 7.0, 7.5, 8.0, 8.5, 9.0, 9.5),
    *(10.0, 10.5, 11.0, 12.0, 12.5, 13.0, 14.0, 15.0, 16.0, 17.0, 18.0, 19.0, 20.0),
)
"""Nominal diameters that EN 10270-1 tabulates and wire dealers stock."""
STRIPS_MM = (0.5, 0.6, 0.8, 1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0)
"""Usual thicknesses of spring strip and flat spring steel (EN 10132, EN 10092)."""
LEAF_ALLOWABLE = 0.7 * 1.35e9
"""Bending stress, Pa: 0.7 Rm, as EN 13906-3 allows, of hardened 51CrV4 (EN 10089)."""
INDEX = (4.0, 16.0)
COILS = (2.5, 200.0)


@dataclass(frozen=True)
class Wanted:
    """A rate (N/m), the deflection that must be possible (m), and the room for it."""

    rate: float
    deflection: float
    outside: float
    length: float  # of the free compression spring, of the extended tension spring
    kind: str = 'compression'
    ends: str = 'hinged'
    tolerance: float = 0.02

    def __post_init__(self) -> None:
        for name in ('rate', 'deflection', 'outside', 'length', 'tolerance'):
            value = getattr(self, name)
            if not (value > 0.0 and math.isfinite(value)):
                raise InputError(f'spring {name} = {value:g} must be above 0')
        if self.kind == 'compression' and self.deflection >= self.length:
            raise InputError(
                f'a compression spring {self.length:g} m long cannot give {self.deflection:g} m; '
                'allow more length or ask for less deflection'
            )


class Checked(NamedTuple):
    """A spring against its duty; `failures` says what speaks against it, empty where nothing."""

    spring: Helical
    force: float  # at full deflection
    stress: float
    utilisation: float  # stress over allowable
    free_length: float
    clearance: float  # what is left to the solid length at full deflection
    slenderness: float
    buckles_at: float
    failures: tuple[str, ...]


class CheckedLeaf(NamedTuple):
    """A leaf against its load."""

    leaf: Leaf
    stress: float
    utilisation: float
    failures: tuple[str, ...]


def candidates(wanted: Wanted) -> list[Checked]:
    """Combinations that pass every check, lightest first.

    Wires of EN 10270-1, coil diameters in whole millimetres below 50 mm and steps of 5 mm above,
    coils in quarter turns.
    """
    found = []
    for wire in WIRES_MM:
        for mean in _mean_diameters(wire, 1e3 * wanted.outside):
            spring = _with_coils(1e-3 * wire, 1e-3 * mean, wanted)
            if spring is not None:
                checked = check(spring, wanted)
                if not checked.failures:
                    found.append(checked)
    return sorted(found, key=lambda c: (c.spring.mass, c.spring.d, c.spring.D))


def check(spring: Helical, wanted: Wanted) -> Checked:
    """A given spring against what is wanted of it."""
    force = spring.rate * wanted.deflection
    stress = spring.shear_stress(force)
    if spring.kind == 'compression':
        free = wanted.length
        clearance = free - wanted.deflection - spring.solid_length
    else:
        free = wanted.length - wanted.deflection
        clearance = free - spring.solid_length
    buckles_at = spring.buckling_deflection(free, wanted.ends)
    utilisation = stress / spring.allowable
    needed = spring.least_gap if spring.kind == 'compression' else 0.0
    failures = (
        _says(abs(spring.rate / wanted.rate - 1.0) > wanted.tolerance, 'rate'),
        _says(not INDEX[0] <= spring.index <= INDEX[1], 'index'),
        _says(spring.outside > wanted.outside, 'outside diameter'),
        _says(utilisation > 1.0, 'stress'),
        _says(clearance < 0.0, 'solid'),
        _says(0.0 <= clearance < needed, 'clearance'),
        _says(buckles_at < wanted.deflection, 'buckles'),
    )
    return Checked(
        spring,
        force,
        stress,
        utilisation,
        free,
        clearance,
        free / spring.D,
        buckles_at,
        tuple(word for word in failures if word),
    )


def leaves(rate: float, load: float, length: float, width: float) -> list[CheckedLeaf]:
    """Leaves of stocked thickness cut to the width that gives `rate` under end load `load` (N).

    Widths up to `width`; those that bend too much come with their failure, least stressed first.
    """
    found = []
    for thickness in STRIPS_MM:
        per_width = Leaf(1.0, 1e-3 * thickness, length).stiffness
        b = rate / per_width
        if 2e-3 * thickness <= b <= width:
            found.append(check_leaf(Leaf(b, 1e-3 * thickness, length), load))
    return sorted(found, key=lambda c: c.stress)


def check_leaf(leaf: Leaf, load: float) -> CheckedLeaf:
    """A given leaf under its load."""
    stress = leaf.bending_stress(load)
    utilisation = stress / LEAF_ALLOWABLE
    return CheckedLeaf(leaf, stress, utilisation, ('stress',) if utilisation > 1.0 else ())


def known_ends(name: str) -> str:
    """`name` if it is a kind of seating; raises InputError listing them."""
    if name not in ENDS:
        raise InputError(f'unknown ends {name!r}; known: {", ".join(ENDS)}')
    return name


def _mean_diameters(wire: float, outside: float) -> list[float]:
    low, high = INDEX[0] * wire, min(INDEX[1] * wire, outside - wire)
    fine = [float(D) for D in range(math.ceil(low), 50)]
    coarse = [float(D) for D in range(50, 2000, 5)]
    return [D for D in (*fine, *coarse) if low <= D <= high]


def _with_coils(d: float, D: float, wanted: Wanted) -> Helical | None:
    exact = Helical(d, D, 1.0, wanted.kind).rate / wanted.rate
    n = round(4.0 * exact) / 4.0
    return Helical(d, D, n, wanted.kind) if COILS[0] <= n <= COILS[1] else None


def _says(wrong: bool, word: str) -> str:
    return word if wrong else ''
