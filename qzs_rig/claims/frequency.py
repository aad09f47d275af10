"""C6: the "natural frequency 20 Hz"."""

from __future__ import annotations

import math

from qzs_rig.claims.verdict import Verdict, judged

K1, PAYLOAD = 20000.0, 50.0
"""Table 1."""


def natural() -> Verdict:
    """omega0 of (27) with Table 1, in both units."""
    omega0 = math.sqrt(K1 / PAYLOAD)
    hz = omega0 / (2.0 * math.pi)
    return Verdict(
        'the natural frequency of the platform is 20 Hz',
        judged(abs(hz - 20.0) < 0.5),
        {'omega0, rad/s': omega0, 'omega0/(2 pi), Hz': hz},
        'omega0 = sqrt(k1/m) of (27): 20 rad/s, not 20 Hz (E8)',
    )
