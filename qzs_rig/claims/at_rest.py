"""C1 to C6, the claims about the platform at rest: stiffness, range, load, springs, frequency."""

from __future__ import annotations

import math

from qzs_rig.claims.paper import K1, L20, PAYLOAD, Verdict
from qzs_rig.mechanics import springs, statics
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import PAPER_DESIGN
from qzs_rig.units import DOFS, GRAVITY

ZERO = 1e-12
"""Rounding of sums of order 1."""
TOLERANCE = 0.05
"""Stiffness over k1 that counts as low."""
PRINTED = {'central': 19973.0, 'suspension': 22570.0}
"""Rates of Table 3, N/m."""
LIMIT = 0.035
SPANS = {'vertical': 0.4, 'horizontal': 0.4, 'vertical_rotation': 0.4, 'horizontal_rotation': 0.4}
"""Range taken for Figure 10, whose axes the text does not give, over L20 or rad."""


def natural_frequency() -> Verdict:
    """omega0 of (27) with Table 1, in both units."""
    omega0 = math.sqrt(K1 / PAYLOAD)
    hz = omega0 / (2.0 * math.pi)
    return Verdict(
        'the natural frequency of the platform is 20 Hz',
        abs(hz - 20.0) < 0.5,
        {'omega0, rad/s': omega0, 'omega0/(2 pi), Hz': hz},
        'omega0 = sqrt(k1/m) of (27): 20 rad/s, not 20 Hz (E8)',
    )


def load_capacity() -> Verdict:
    """(24) as printed, with the load that (8) has at the working point beside it."""
    to_kg = K1 * L20 / GRAVITY
    saturation = statics.saturated_load(PAPER_DESIGN)
    at_3 = float(statics.load_capacity(PAPER_DESIGN, 3.0))
    holds = at_3 > 0.98 * saturation and saturation * to_kg >= PAYLOAD
    return Verdict(
        'load capacity (24) saturates at 0.05 beyond |x0| of about 3 and carries 50 kg',
        holds,
        {
            'saturation k3 a': saturation,
            '(24) at x0 = 3': at_3,
            'saturation, kg': saturation * to_kg,
            '(8) at the working point, kg': PAPER_DESIGN.b * to_kg,
        },
        '(24) does; but (8) is in balance at the working point only under b = k3 L1, not under '
        'the 50 kg of Table 1 (E21); qzs-rig statics, qzs-rig design --check',
    )


def vertical_stiffness() -> Verdict:
    """C1: zero vertical stiffness under (16), and its range for the designs of Figure 9."""
    law, figures, widths = RESTORING['closed_form'], {}, []
    for design in statics.triples(PAPER_DESIGN):
        low, high = statics.soft_range(law, design, 'vertical', TOLERANCE) or (0.0, 0.0)
        # to both sides alike: counted one by one, a dip below 0 can pass for width
        widths.append(min(-low, high))
        figures[f'stiffness at 0, A = {design.A:.3g}'] = law.taylor(design)[0][0]
        figures[f'|K| <= {TOLERANCE:g} up to, A = {design.A:.3g}'] = widths[-1]
    zero = all(abs(v) < ZERO for name, v in figures.items() if name.startswith('stiffness'))
    figures['least stiffness, paper design'] = statics.lowest_stiffness(
        law, PAPER_DESIGN, 'vertical', 0.1
    )
    return Verdict(
        'vertical stiffness is zero at the working point under (16); the closer A to 1, the wider '
        'the low-stiffness range (Fig 9)',
        zero and widths[0] > widths[1] > widths[2],
        figures,
        f'(9) at 0, and how far to both sides |K| <= {TOLERANCE:g}, for the designs of Figure 9; '
        'beside the working point K falls slightly below 0 (E20); '
        'qzs-rig statics --law closed_form',
    )


def horizontal_stiffness() -> Verdict:
    """C2: zero horizontal stiffness, which takes the wrong sign of (10)-(11)."""
    number = DOFS.index('horizontal')
    printed, right = (
        RESTORING[name].taylor(PAPER_DESIGN)[number][0] for name in ('closed_form', 'corrected')
    )
    return Verdict(
        'horizontal stiffness is always zero at 0',
        abs(printed) < ZERO and abs(right) < ZERO,
        {'(11) as printed': printed, 'right sign, 2 A a²': right},
        'slope of (11) at 0: zero as printed, but there the stretched spring pushes (E4); '
        'qzs-rig statics --law corrected --dof horizontal --at 0',
    )


def spring_rates() -> Verdict:
    """(33) for both helical springs, to the printed newton per metre."""
    found = {'central': springs.CENTRAL.rate, 'suspension': springs.SUSPENSION.rate}
    return Verdict(
        'spring rates of Table 3: 19 973 N/m central, 22 570 N/m suspension',
        all(abs(found[name] - PRINTED[name]) < 0.5 for name in PRINTED),
        {f'{name}, N/m': rate for name, rate in found.items()},
        'k = G d⁴/(8 n D³), (33); qzs-rig springs',
    )


def taylor_deviation() -> Verdict:
    """Largest difference over largest force, net of the static load, and where it is LIMIT."""
    laws = RESTORING['taylor'], RESTORING['closed_form']
    figures, within = {}, []
    for dof, span in SPANS.items():
        largest = statics.deviation(*laws, PAPER_DESIGN, dof, span).relative
        figures[f'{dof} over {span:g}'] = largest
        within.append(largest <= LIMIT)
        if not within[-1]:
            reach = statics.reach_within(*laws, PAPER_DESIGN, dof, LIMIT)
            figures[f'{dof} within 3.5 % up to'] = reach
    return Verdict(
        'the Taylor laws deviate by no more than 3.5 % from the closed form (Fig 10)',
        all(within),
        figures,
        'largest difference over largest force for |x| up to the range; 3.5 % holds near the '
        'working point only (E22); qzs-rig statics',
    )
