"""What to beware of in a platform, proposed or given. A new warning is one function and one line
in WARNINGS."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from qzs_rig.design.proposal import REACH, Proposal
from qzs_rig.design.vertical_motion import Motion, Response
from qzs_rig.mechanics import spring_selection as selection
from qzs_rig.mechanics.platform import Platform
from qzs_rig.mechanics.restoring.law import Design
from qzs_rig.mechanics.spring_selection import Checked, CheckedLeaf, Wanted
from qzs_rig.mechanics.statics import Conditions, conditions, saturated_load, suspension_for
from qzs_rig.parameters import RunSpec
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import GRAVITY

ZERO = 1e-9
"""A stiffness over k1 that is no stiffness: rounding of lengths given in metres."""
QUASI_ZERO = 0.05
"""A stiffness over k1 that still is quasi-zero."""
LOAD_TOLERANCE = 0.02
"""Relative mismatch of static load and weight that a trim of the springs takes up."""
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


@dataclass(frozen=True)
class Case:
    """A platform with its payload (kg), its level and the stroke it must allow (m, or None)."""

    design: Design
    k1: float
    L20: float
    mass: float
    motion: Motion | None  # None: nothing moves the base vertically
    stroke: float | None

    @cached_property
    def response(self) -> Response | None:
        """Figures of the vertical motion."""
        return self.motion.response() if self.motion else None

    @cached_property
    def orders(self) -> list[Order]:
        """Springs for it under its own static load."""
        return orders(self.design, self.k1, self.L20, self.carries * GRAVITY)

    @property
    def conditions(self) -> Conditions:
        """Stiffnesses at the working point by (16) to (19), over k1."""
        return conditions(self.design)

    @property
    def carries(self) -> float:
        """Mass (kg) that rests at the working point: b k1 L20 = k3 L1 (8)."""
        return float(self.design.b * self.k1 * self.L20 / GRAVITY)

    @property
    def saturation(self) -> float:
        """Mass (kg) at which (24) saturates."""
        return saturated_load(self.design) * self.k1 * self.L20 / GRAVITY

    @classmethod
    def proposed(cls, p: Proposal) -> Case:
        """A proposal under the level of its wish."""
        return cls(p.design, p.k1, p.L20, p.wish.mass, p.motion, p.wish.stroke)

    @classmethod
    def of_spec(cls, spec: RunSpec, stroke: float | None = None) -> Case:
        """The platform of a scenario under its vertical excitation."""
        platform = Platform.from_spec(spec)
        L20 = spec.number('platform.L20')
        moves = spec.number('excitation.amplitude.vertical') > 0.0
        motion = Motion(Oscillator.driven(spec, 'vertical')) if moves else None
        return cls(platform.design, platform.stiffness[0], L20, platform.mass[0], motion, stroke)


def negative_stiffness(case: Case) -> str | None:
    """(16) below zero: the plate snaps through."""
    what = 'negative: the plate snaps aside'
    return _misses_16(case, what) if case.conditions.vertical < -ZERO else None


def stiff(case: Case) -> str | None:
    """(16) above zero: no quasi-zero stiffness."""
    return _misses_16(case, 'not quasi-zero') if case.conditions.vertical > QUASI_ZERO else None


def _misses_16(case: Case, what: str) -> str:
    A, k3, _, _, a, _ = case.design.ratios
    K = case.conditions.vertical
    return (
        f'vertical stiffness at the working point is {K:.4g} k1, {what}; (16) wants '
        f'A = {suspension_for(k3, a):.6g}, not {A:.6g}'
    )


def tipping(case: Case) -> str | None:
    """(19): k3_hat below A L0_hat."""
    A, k3, _, L0, _, _ = case.design.ratios
    stiffness = case.conditions.horizontal_rotation
    if stiffness < -ZERO:
        return (
            f'the plate tips over: k3_hat = {k3:.4g} is below A L0_hat = {A * L0:.4g} (19), '
            f'stiffness {stiffness:.4g} k1 L20 L0 in horizontal rotation (E7); '
            f'L0 up to {k3 / A * case.L20:.4g} m stands'
        )
    return None


def load(case: Case) -> str | None:
    """The static load against the weight."""
    ratio = case.carries / case.mass
    if abs(ratio - 1.0) <= LOAD_TOLERANCE:
        return None
    k3 = case.mass * GRAVITY / (case.design.L1 * case.L20)
    what = 'insufficient load capacity' if ratio < 1.0 else 'payload too light'
    return (
        f'{what}: at the working point the springs carry {case.carries:.1f} kg (b k1 L20, E21), '
        f'the payload is {case.mass:.1f} kg; k3 = {k3:.5g} N/m carries it'
    )


def critical(case: Case) -> str | None:
    """The level against the critical amplitude."""
    motion = case.motion
    if motion is None or not motion.unbounded or motion.critical_hat is None:
        return None
    level, most = (hat * case.L20 for hat in (motion.oscillator.amplitude, motion.critical_hat))
    return (
        f'{level:g} m is beyond the critical amplitude {most:.4g} '
        'm (2 zeta L20/sqrt(3/4 c3)): in one-term theory the resonance has no peak and no '
        'jump-down; lower the displacement, damp more, or hold the acceleration constant'
    )


def stress(case: Case) -> str | None:
    """Springs that nobody can make."""
    failing = [f'{o.spring}: {o.text}' for o in case.orders if not o.fits]
    return f'spring stress: {"; ".join(failing)}' if failing else None


def swing(case: Case) -> str | None:
    """Relative motion against stroke and geometry."""
    moves = case.response.relative if case.response else None
    wide = max(moves or 0.0, case.stroke or 0.0)
    if case.stroke is not None and moves is not None and moves > case.stroke * (1.0 + 1e-6):
        return f'the plate swings {moves:.4g} m, beyond the stroke of {case.stroke:g} m'
    if wide > case.design.L1 * case.L20:
        return (
            f'{wide:.4g} m is beyond the geometry: the central spring is slack at '
            f'{case.design.L1 * case.L20:.4g} m (L1)'
        )
    if wide > REACH * case.L20 * (1.0 + 1e-6):
        return (
            f'{wide:.4g} m is {wide / case.L20:.2g} L20: beyond {REACH:g} L20 the law is stiff and '
            'no longer cubic (E22), so theory misleads; lengthen L20 or lower the level'
        )
    return None


WARNINGS: dict[str, Callable[[Case], str | None]] = {
    'negative stiffness': negative_stiffness,
    'not quasi-zero': stiff,
    'tipping': tipping,
    'load': load,
    'critical amplitude': critical,
    'spring stress': stress,
    'stroke': swing,
}


def warnings(case: Case) -> dict[str, str]:
    """The text of each warning that applies, by its name in WARNINGS."""
    said = {name: rule(case) for name, rule in WARNINGS.items()}
    return {name: text for name, text in said.items() if text}
