"""C4: what the platform carries."""

from __future__ import annotations

from qzs_rig.claims.verdict import Verdict, judged
from qzs_rig.mechanics import statics
from qzs_rig.mechanics.design import PAPER_DESIGN
from qzs_rig.units import GRAVITY

K1, L20, PAYLOAD = 20000.0, 0.6, 50.0
"""Table 1."""


def capacity() -> Verdict:
    """(24) as printed, with the load that (8) has at the working point beside it."""
    to_kg = K1 * L20 / GRAVITY
    saturation = statics.saturated_load(PAPER_DESIGN)
    at_3 = float(statics.load_capacity(PAPER_DESIGN, 3.0))
    holds = at_3 > 0.98 * saturation and saturation * to_kg >= PAYLOAD
    return Verdict(
        'load capacity (24) saturates at 0.05 beyond |x0| of about 3 and carries 50 kg',
        judged(holds),
        {
            'saturation k3 a': saturation,
            '(24) at x0 = 3': at_3,
            'saturation, kg': saturation * to_kg,
            '(8) at the working point, kg': PAPER_DESIGN.b * to_kg,
        },
        '(24) does; but (8) is in balance at the working point only under b = k3 L1, not under '
        'the 50 kg of Table 1 (E21); qzs-rig statics, qzs-rig design --check',
    )
