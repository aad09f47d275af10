"""The figures 9 to 12 of the paper for any law and design: what is drawn, not how."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from qzs_rig.mechanics import statics
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import Design
from qzs_rig.report.datasheet import Summary
from qzs_rig.report.names import dof_name
from qzs_rig.report.sheet import PALE, Curve, Panel, Sheet, hue
from qzs_rig.samples import Array
from qzs_rig.units import DOFS, TRANSLATIONS

SPANS = {
    'vertical': 0.8,
    'horizontal': 0.8,
    'vertical_rotation': 1.5,
    'horizontal_rotation': 0.9,
}
"""How far Figure 9 goes, in L20 or rad; 0.9 keeps clear of |theta| = 1, where (15) ends."""
NEAR_SPAN = 0.5
POINTS = 401
TRIM_KG = 40.0


def sheets(found: Summary) -> list[Sheet]:
    """All figures."""
    return [_curves(found), _expansions(found), _initial_load(found), _capacity(found)]


def curves(found: Summary) -> tuple[tuple[str, ...], list[list[Any]]]:
    """Header and columns of `statics.csv`: force with static load, and stiffness, of the law in
    every motion."""
    along = {
        dof: statics.curve(
            found.law, found.design, dof, np.linspace(-SPANS[dof], SPANS[dof], POINTS)
        )
        for dof in DOFS
    }
    names = ('law', 'dof', 'x', 'force', 'stiffness')
    columns = [[value for c in along.values() for value in getattr(c, name).tolist()]
               for name in names[2:]]  # fmt: skip
    dofs = [dof for dof in DOFS for _ in range(POINTS)]
    return names, [[found.law.name] * len(dofs), dofs, *columns]


def designs(found: Summary) -> list[Design]:
    """The design itself, then the paper's triples that differ from it."""
    own = found.design
    others = [d for d in statics.triples(own) if not np.allclose(d, own, rtol=1e-9, atol=0)]
    return [own, *others]


def _curves(found: Summary) -> Sheet:
    panels = [
        _law_panel(found, k, dof, stiffness)
        for k, (stiffness, dof) in enumerate((s, dof) for s in (False, True) for dof in DOFS)
    ]
    return Sheet(
        'figure_9',
        f'Figure 9. Force, torque and stiffness of law {found.law.name}',
        'The design and the triples that fulfil (16). Forces are net of the static load.',
        tuple(panels),
        columns=4,
    )


def _law_panel(found: Summary, k: int, dof: str, stiffness: bool) -> Panel:
    x, number = np.linspace(-SPANS[dof], SPANS[dof], POINTS), DOFS.index(dof)
    evaluate = found.law.stiffness if stiffness else found.law.force
    lines = tuple(
        Curve(_ratios(design), x, evaluate(design, _along(number, x))[:, number], hue(style))
        for style, design in enumerate(designs(found))
    )
    y_label = 'stiffness / k1' if stiffness else _force_word(dof)
    return Panel(f'({"abcdefgh"[k]}) {dof_name(dof)}', _motion_word(dof), y_label, lines)


def _expansions(found: Summary) -> Sheet:
    panels = []
    for number, dof in enumerate(DOFS):
        x = np.linspace(-NEAR_SPAN, NEAR_SPAN, POINTS)
        lines = tuple(
            _law_curve(
                name, style, x, RESTORING[name].force(found.design, _along(number, x))[:, number]
            )
            for style, name in enumerate(('closed_form', 'corrected', 'taylor', 'printed'))
        )
        title = f'({"abcd"[number]}) {dof_name(dof)}'
        panels.append(Panel(title, _motion_word(dof), _force_word(dof), lines))
    return Sheet(
        'figure_10',
        'Figure 10. Closed forms and third-order laws',
        f'{_ratios(found.design)}. In (b) and (d) the closed form is uneven (errata E4, E7); in '
        '(c) the printed cubic term has L0 where the expansion has L0³ (E5).',
        tuple(panels),
        columns=2,
    )


def _initial_load(found: Summary) -> Sheet:
    A, k3, L1, _, a, _ = found.design.ratios
    x = np.linspace(-L1, 0.5, POINTS)
    length = np.sqrt(x * x + a * a)
    shares = (
        ('central spring', x),
        ('suspension springs', A * x * (1.0 - 1.0 / length)),
        ('leaf springs', k3 * (a / length) * (x + L1)),
    )
    total = np.sum([y for _, y in shares], axis=0)
    carried = Panel(
        '(a) who carries the load, Eq (8)',
        _motion_word('vertical'),
        'force',
        (
            *(Curve(name, x, y, hue(style)) for style, (name, y) in enumerate(shares)),
            Curve('platform', x, total, hue(3), 'dashed'),
        ),
    )
    return Sheet(
        'figure_11',
        'Figure 11. The initial load',
        'At x = 0 central and suspension springs cancel and the leaf springs carry all of b. A '
        'payload off balance rests where the curve (b) says.',
        (carried, _rest(found)),
        columns=2,
    )


def _rest(found: Summary) -> Panel:
    kg = np.linspace(-TRIM_KG, TRIM_KG, 161)
    lines = []
    for style, name in enumerate(('closed_form', 'taylor', 'symmetric')):
        load = kg / found.mass(1.0)
        rest = [statics.equilibrium(RESTORING[name], found.design, f) for f in load.tolist()]
        lines.append(_law_curve(name, style, kg, np.array(rest)))
    return Panel(
        '(b) where an unbalanced payload rests',
        'payload off balance, kg',
        'rest position x / L20',
        tuple(lines),
    )


def _capacity(found: Summary) -> Sheet:
    own = found.design
    by_k3 = _with_own(own.k3, (0.1, 0.5, 1.0))
    by_L1 = _with_own(own.L1, (0.7, 0.95))
    return Sheet(
        'figure_12',
        'Figure 12. Load capacity, Eq (24)',
        'The load saturates at k3 a beyond about |x0| = 3.',
        (
            _capacity_panel(
                '(a) leaf springs',
                ((f'k3 = {k:.4g}', Design.of(own.A, k, own.L1, own.L0)) for k in by_k3),
            ),
            _capacity_panel(
                '(b) stretch of the central spring',
                ((f'L1 = {L:.4g}', Design.of(own.A, own.k3, L, own.L0)) for L in by_L1),
            ),
        ),
        columns=2,
    )


def _capacity_panel(title: str, cases: Iterable[tuple[str, Design]]) -> Panel:
    x0 = np.linspace(-5.0, 5.0, POINTS)
    lines = tuple(
        Curve(label, x0, statics.load_capacity(design, x0), hue(style))
        for style, (label, design) in enumerate(cases)
    )
    return Panel(title, 'initial displacement x0 / L20', 'load / (k1 L20)', lines)


def _law_curve(name: str, style: int, x: Array, y: Array) -> Curve:
    """The first is broad and pale, so that the others show on it where they agree."""
    words = name.replace('_', ' ')
    if style == 0:
        return Curve(words, x, y, PALE, width=4.0)
    return Curve(words, x, y, hue(style), ('', 'solid', 'dashed', 'dotted')[style])


def _with_own(own: float, others: Sequence[float]) -> list[float]:
    return [own, *(value for value in others if abs(value - own) > 1e-9)]


def _along(number: int, x: Array) -> Array:
    motion = np.zeros((len(x), len(DOFS)))
    motion[:, number] = x
    return motion


def _ratios(design: Design) -> str:
    return f'A = {design.A:.4g}, k3 = {design.k3:.4g}, L0 = {design.L0:.4g}'


def _motion_word(dof: str) -> str:
    return 'x / L20' if dof in TRANSLATIONS else 'rotation, rad'


def _force_word(dof: str) -> str:
    return 'force / (k1 L20)' if dof in TRANSLATIONS else 'torque / (k1 L20 L0)'
