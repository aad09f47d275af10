"""C1 and C2: what is zero at the working point, and for how far."""

from __future__ import annotations

from qzs_rig.claims.verdict import Verdict, judged
from qzs_rig.mechanics import statics
from qzs_rig.mechanics.design import PAPER_DESIGN
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.units import DOFS

ZERO = 1e-12
"""Rounding of sums of order 1."""
TOLERANCE = 0.05
"""Stiffness over k1 that counts as low."""


def vertical() -> Verdict:
    """C1: zero vertical stiffness under (16), and its range for the designs of Figure 9."""
    law, figures, widths = RESTORING['closed_form'], {}, []
    for design in statics.triples(PAPER_DESIGN.L1):
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
        judged(zero and widths[0] > widths[1] > widths[2]),
        figures,
        f'(9) at 0, and how far to both sides |K| <= {TOLERANCE:g}, for the designs of Figure 9; '
        'beside the working point K falls slightly below 0 (E20); '
        'qzs-rig statics --law closed_form',
    )


def horizontal() -> Verdict:
    """C2: zero horizontal stiffness, which takes the wrong sign of (10)-(11)."""
    number = DOFS.index('horizontal')
    printed, right = (
        RESTORING[name].taylor(PAPER_DESIGN)[number][0] for name in ('closed_form', 'corrected')
    )
    return Verdict(
        'horizontal stiffness is always zero at 0',
        judged(abs(printed) < ZERO and abs(right) < ZERO),
        {'(11) as printed': printed, 'right sign, 2 A a²': right},
        'slope of (11) at 0: zero as printed, but there the stretched spring pushes (E4); '
        'qzs-rig statics --law corrected --dof horizontal --at 0',
    )
