"""C5: the spring rates of Table 3."""

from __future__ import annotations

from qzs_rig.claims.verdict import Verdict, judged
from qzs_rig.mechanics import springs

PRINTED = {'central': 19973.0, 'suspension': 22570.0}


def rates() -> Verdict:
    """(33) for both helical springs, to the printed newton per metre."""
    found = {'central': springs.CENTRAL.rate, 'suspension': springs.SUSPENSION.rate}
    return Verdict(
        'spring rates of Table 3: 19 973 N/m central, 22 570 N/m suspension',
        judged(all(abs(found[name] - PRINTED[name]) < 0.5 for name in PRINTED)),
        {f'{name}, N/m': rate for name, rate in found.items()},
        'k = G d⁴/(8 n D³), (33); qzs-rig springs',
    )
