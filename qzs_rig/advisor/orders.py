"""Springs that a lab would order for a platform, and whether any exists (erratum E23)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from qzs_rig.mechanics import spring_selection as selection
from qzs_rig.mechanics.design import Design
from qzs_rig.mechanics.spring_selection import Checked, CheckedLeaf, Wanted

PARALLEL = (1, 2, 4)
"""How many central springs may share the load."""
SUSPENSIONS = 4
LEAVES = (4, 8, 16)
"""How many leaves: one, two or four on each side."""
SLENDER = 1.0 / 3.0
"""Outside diameter of a helical spring over L20, at most, and width of a leaf."""


class Order(NamedTuple):
    """`number` springs in parallel; `text` says which, or what speaks against all of them."""

    spring: str
    number: int
    rate: float  # of each, N/m
    text: str
    fits: bool


def orders(design: Design, k1: float, L20: float, load: float) -> list[Order]:
    """Central, suspension and leaf springs at the working point; `load` (N) on all leaves.

    Central: stretched by L1 from a body no longer than L1. Suspension: a quarter of k2 each, free
    length L20, pressed to a L20, guided by a rod where hinged ones buckle. Leaf: L20 long. None
    may be thicker or wider than SLENDER L20. A rate of zero asks for no spring.
    """
    found = [_central(design, k1, L20)]
    if design.A > 0.0:
        found.append(_suspension(design, k1, L20))
    if design.k3 > 0.0:
        found.append(_leaf(design, k1, L20, load))
    return found


def _central(design: Design, k1: float, L20: float) -> Order:
    stretch = design.L1 * L20
    for count in PARALLEL:
        wanted = Wanted(k1 / count, stretch, SLENDER * L20, 2.0 * stretch, 'tension')
        found = selection.candidates(wanted)
        if found:
            break
    return _helical('central', count, wanted, found)


def _suspension(design: Design, k1: float, L20: float) -> Order:
    rate = design.A * k1 / SUSPENSIONS
    for ends in ('hinged', 'fixed'):
        wanted = Wanted(rate, (1.0 - design.a) * L20, SLENDER * L20, L20, ends=ends)
        found = selection.candidates(wanted)
        if found:
            break
    order = _helical('suspension', SUSPENSIONS, wanted, found)
    guided = found and ends == 'fixed'
    return order._replace(text=f'{order.text}, guided against buckling') if guided else order


def _helical(name: str, count: int, wanted: Wanted, found: Sequence[Checked]) -> Order:
    if found:
        s = found[0].spring
        text = (
            f'wire {1e3 * s.d:g} mm, coil {1e3 * s.D:g} mm, {s.n:g} coils, '
            f'{1e-6 * found[0].stress:.0f} of {1e-6 * s.allowable:.0f} MPa, {s.mass:.2g} kg'
        )
        return Order(name, count, wanted.rate, text, True)
    text = f'no standard wire bears {wanted.rate * wanted.deflection:.0f} N'
    text += f' over {1e3 * wanted.deflection:.0f} mm within {1e3 * wanted.outside:.0f} mm outside'
    return Order(name, count, wanted.rate, text, False)


def _leaf(design: Design, k1: float, L20: float, load: float) -> Order:
    for count in LEAVES:
        rate = design.k3 * k1 / count
        found = selection.leaves(rate, load / count, L20, SLENDER * L20)
        good = [item for item in found if not item.failures]
        if good:
            return Order('leaf', count, rate, _leaf_text(good[0]), True)
    text = _leaf_text(found[0]) if found else 'no stocked strip has this rate'
    return Order('leaf', count, rate, text, False)


def _leaf_text(checked: CheckedLeaf) -> str:
    leaf = checked.leaf
    return (
        f'{1e3 * leaf.b:.0f} x {1e3 * leaf.h:g} mm, {1e3 * leaf.length:.0f} mm long, '
        f'{1e-6 * checked.stress:.0f} of {1e-6 * selection.LEAF_ALLOWABLE:.0f} MPa'
    )
