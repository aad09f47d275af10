"""A platform proposed or checked, as tables and as a document for programs."""

from __future__ import annotations

from typing import Any

from qzs_rig.design.check import QUASI_ZERO, Case, warnings
from qzs_rig.design.proposal import Proposal
from qzs_rig.mechanics import statics
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.report.table import MISSING, Table, number
from qzs_rig.units import DOFS

UNITS = {'k1': 'N/m', 'k2': 'N/m', 'k3': 'N/m', 'L1': 'm', 'L20': 'm', 'L0': 'm'}


def proposal_table(p: Proposal) -> Table:
    """Springs and lengths, each with its rule."""
    rows = tuple(
        (name, f'{getattr(p, name):.5g}', unit, p.why[name]) for name, unit in UNITS.items()
    )
    wish = p.wish
    caption = (
        f'Platform for {wish.mass:g} kg, onset {wish.onset:g} Hz at {wish.level_text}, '
        f'stroke {wish.stroke:g} m, zeta {wish.zeta:g}'
    )
    return Table(caption, ('', 'is', 'unit', 'why'), rows, labels=4)


def tables(case: Case) -> list[Table]:
    """Three tables: at rest, in motion (none where nothing moves the base), springs to order."""
    return [_rest(case), *_motion(case), _orders(case)]


def _rest(case: Case) -> Table:
    d, figures = case.design, static_figures(case)
    rows = (
        ('A, k3_hat, L1_hat, L0_hat', f'{d.A:.5g}, {d.k3:.5g}, {d.L1:.5g}, {d.L0:.5g}'),
        *(
            (f'K(0) {dof}, over k1 or k1 L20 L0', _zero(K))
            for dof, K in figures['stiffness'].items()
        ),
        (f'|K| <= {QUASI_ZERO:g} k1 from (mm, up)', _mm(figures['soft_up'])),
        (f'|K| <= {QUASI_ZERO:g} k1 to (mm, down)', _mm(figures['soft_down'])),
        ('carried at the working point, b k1 L20 (kg)', f'{case.carries:.2f}'),
        ('payload (kg)', f'{case.mass:.2f}'),
        ('(24) saturates at (kg)', f'{case.saturation:.2f}'),
        ('spare against tipping (19), 1 - A L0_hat/k3_hat', number(figures['tip_margin'], '.3g')),
    )
    return Table('At rest', ('what', 'is'), rows, labels=1)


def _motion(case: Case) -> list[Table]:
    r, m = case.response, case.motion
    if r is None or m is None:
        return []
    rows = [
        ('omega0/(2 pi), Hz', f'{m.oscillator.hertz:.4g}'),
        ('zeta', f'{m.oscillator.zeta:.4g}'),
        ('onset: T < 1 above, Hz', number(r.onset)),
        ('the same at vanishing level (E20), Hz', number(m.settled)),
        ('peak, Hz', number(r.peak_hz)),
        ('peak T', number(r.peak_height)),
        ('jump up, Hz', number(r.jump_up)),
        ('jump down, Hz', number(r.jump_down)),
        ('largest relative motion, mm', number(r.relative and 1e3 * r.relative, '.4g')),
        ('stroke, mm', number(case.stroke and 1e3 * case.stroke, '.4g')),
    ]
    if m.critical_hat is not None:
        rows.append(
            ('critical displacement, mm', f'{1e3 * m.critical_hat * m.oscillator.length:.4g}')
        )
    return [Table('Vertical motion at this level, one-term theory', ('what', 'is'), tuple(rows), 1)]


def _orders(case: Case) -> Table:
    rows = tuple(
        (o.spring, f'{o.number} x', f'{o.rate:.5g}', 'yes' if o.fits else 'NO', o.text)
        for o in case.orders
    )
    header = ('spring', 'count', 'N/m each', 'exists', 'what')
    return Table('Springs to order', header, rows, labels=5)


def static_figures(case: Case) -> dict[str, Any]:
    """At rest: stiffness at 0, the soft range (m), margin against tipping; None where none."""
    law = RESTORING['corrected']
    soft = statics.soft_range(law, case.design, 'vertical', QUASI_ZERO)
    A, k3, _, L0, _, _ = case.design.ratios
    stiffness = [c1 for c1, _ in law.cubic(case.design)]
    return {
        'stiffness': dict(zip(DOFS, stiffness, strict=True)),
        'soft_up': soft[0] * case.L20 if soft else None,
        'soft_down': soft[1] * case.L20 if soft else None,
        'carries_kg': case.carries,
        'payload_kg': case.mass,
        'saturation_kg': case.saturation,
        'tip_margin': 1.0 - A * L0 / k3 if k3 else None,
    }


def document(case: Case, p: Proposal | None = None) -> dict[str, Any]:
    """For --json, SI but for the ratios of `design`."""
    answer = case.response
    body: dict[str, Any] = {'wish': vars(p.wish).copy()} if p else {}
    if p:
        body['proposal'] = {name: getattr(p, name) for name in UNITS}
        body['why'] = p.why
    return body | {
        'design': case.design.named,
        'static': static_figures(case),
        'dynamic': answer._asdict() if answer else None,
        'springs': [order._asdict() for order in case.orders],
        'margins': _margins(case, p),
        'warnings': warnings(case),
    }


def _margins(case: Case, p: Proposal | None) -> dict[str, float | None]:
    """Spare over wanted; None where there is nothing to compare."""
    r = case.response
    critical = case.motion.critical_hat if case.motion else None
    level = case.motion.oscillator.amplitude if case.motion else 0.0
    return {
        'onset': 1.0 - r.onset / p.wish.onset if p and r and r.onset is not None else None,
        'stroke': 1.0 - r.relative / case.stroke
        if case.stroke and r and r.relative is not None
        else None,
        'level': 1.0 - level / critical if critical else None,
        'load': case.carries / case.mass - 1.0,
    }


def _zero(value: float) -> str:
    return '0' if abs(value) < 1e-14 else f'{value:.4g}'


def _mm(value: float | None) -> str:
    return MISSING if value is None else f'{1e3 * value:.1f}'
