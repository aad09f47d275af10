"""What there is to say about a design at rest: numbers, tables, one JSON document."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from qzs_rig.mechanics import statics
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import Design, RestoringLaw
from qzs_rig.report.names import dof_name
from qzs_rig.report.table import MISSING, Table, number
from qzs_rig.units import DOFS, GRAVITY

PAPER_DEVIATION = 0.035
"""What the paper says of Fig 10: no more than 3.5 %."""
REACHES = (0.05, 0.1, 0.2, 0.4)
NEAR = 0.1
"""Where the lowest stiffness is looked for."""


class Motion(NamedTuple):
    """One degree of freedom at rest."""

    dof: str
    stiffness: float  # at the working point
    lowest: float  # within NEAR
    soft: tuple[float, float] | None
    deviations: tuple[float, ...]  # of the Taylor law from the closed form over REACHES
    within: float  # reach with PAPER_DEVIATION


class Summary(NamedTuple):
    """A law and a design at rest; loads in k1 L20 and, with `force_scale` (N), in kg."""

    law: RestoringLaw
    design: Design
    force_scale: float
    tolerance: float
    conditions: statics.Conditions
    motions: tuple[Motion, ...]

    def mass(self, load: float) -> float:
        """A load over k1 L20 as the mass that weighs it."""
        return load * self.force_scale / GRAVITY


def summary(law: RestoringLaw, design: Design, force_scale: float, tolerance: float) -> Summary:
    """Everything the table says."""
    return Summary(
        law,
        design,
        force_scale,
        tolerance,
        statics.conditions(design),
        tuple(_motion(law, design, dof, tolerance) for dof in DOFS),
    )


def _motion(law: RestoringLaw, design: Design, dof: str, tolerance: float) -> Motion:
    taylor, exact = RESTORING['taylor'], RESTORING['closed_form']
    return Motion(
        dof,
        law.taylor(design)[DOFS.index(dof)][0],
        statics.lowest_stiffness(law, design, dof, NEAR),
        statics.soft_range(law, design, dof, tolerance),
        tuple(statics.deviation(taylor, exact, design, dof, r).relative for r in REACHES),
        statics.reach_within(taylor, exact, design, dof, PAPER_DEVIATION),
    )


def tables(found: Summary, dofs: Sequence[str] = DOFS) -> list[Table]:
    """Design, conditions, stiffness, load, deviation."""
    return [_conditions(found), _stiffness(found, dofs), _load(found), _deviation(found, dofs)]


def _conditions(found: Summary) -> Table:
    design, c = found.design, found.conditions
    A, k3, L1, L0, a, _ = design.ratios
    rows = (
        ('(16)', 'vertical stiffness 1 + A - A/a + k3', _signed(c.vertical), '0'),
        ('(16)', 'A for this k3 and a', f'{A:.6g}', f'{statics.suspension_for(k3, a):.6g}'),
        ('(17)', 'A, with a/(1 - a) right (E3)', f'{A:.6g}', f'> {c.least_suspension:.6g}'),
        ('(18)', 'vertical rotation k3 L0', _signed(c.vertical_rotation), '0, never'),
        ('(19)', 'horizontal rotation k3 - A L0', _signed(c.horizontal_rotation), '0, not below'),
    )
    caption = f'QZS conditions: A = {A:g}, k3 = {k3:g}, L1 = {L1:g}, L0 = {L0:g}, a = {a:g}'
    return Table(caption, ('Eq', 'what', 'is', 'wanted'), rows)


def _stiffness(found: Summary, dofs: Sequence[str]) -> Table:
    rows = tuple(
        (dof_name(m.dof), _signed(m.stiffness), _signed(m.lowest), *_ends(m.soft))
        for m in found.motions
        if m.dof in dofs
    )
    soft = f'|K| <= {found.tolerance:g}'
    header = ('degree of freedom', 'K(0)', f'least, |x| <= {NEAR:g}', f'{soft} from', 'to')
    return Table(f'Stiffness of law {found.law.name}', header, rows, labels=1)


def _load(found: Summary) -> Table:
    design = found.design
    capacity = statics.saturated_load(design)
    at_3 = float(statics.load_capacity(design, 3.0))
    rows = (
        ('(8)', 'static load b at the working point', *_loads(found, design.b)),
        ('(24)', 'load capacity at x0 = 3', *_loads(found, at_3)),
        ('(24)', 'saturation k3 a', *_loads(found, capacity)),
    )
    return Table('Load', ('Eq', 'what', '/ (k1 L20)', 'kg'), rows)


def _deviation(found: Summary, dofs: Sequence[str]) -> Table:
    rows = tuple(
        (dof_name(m.dof), *(f'{100 * d:.3g}' for d in m.deviations), number(m.within, '.3g'))
        for m in found.motions
        if m.dof in dofs
    )
    limit = f'{100 * PAPER_DEVIATION:g} % up to'
    return Table(
        'Taylor law against closed form: largest difference over largest force, %',
        ('degree of freedom', *(f'|x| <= {r:g}' for r in REACHES), limit),
        rows,
        labels=1,
    )


def document(found: Summary) -> dict[str, Any]:
    """The summary for --json."""
    design, c = found.design, found.conditions
    capacity = statics.saturated_load(design)
    return {
        'law': found.law.name,
        'units': 'nondimensional',
        'design': design.named,
        'conditions': c._asdict() | {'A_wanted': statics.suspension_for(design.k3, design.a)},
        'tolerance': found.tolerance,
        'dofs': {m.dof: _motion_document(m) for m in found.motions},
        'static_load': {'b': design.b, 'kg': found.mass(design.b)},
        'load_capacity': {'saturation': capacity, 'kg': found.mass(capacity)},
    }


def _motion_document(motion: Motion) -> dict[str, Any]:
    return {
        'stiffness': motion.stiffness,
        'lowest_stiffness': motion.lowest,
        'soft_range': list(motion.soft) if motion.soft else None,
        'taylor_deviation': dict(zip(map(str, REACHES), motion.deviations, strict=True)),
        'taylor_within_3.5_percent': motion.within,
    }


def _signed(value: float) -> str:
    # a few roundings of terms of order 1 are a zero
    return '0' if abs(value) < 1e-14 else f'{value:.5g}'


def _ends(soft: tuple[float, float] | None) -> tuple[str, str]:
    return (f'{soft[0]:.4g}', f'{soft[1]:.4g}') if soft else (MISSING, MISSING)


def _loads(found: Summary, load: float) -> tuple[str, str]:
    return f'{load:.5g}', f'{found.mass(load):.1f}'
