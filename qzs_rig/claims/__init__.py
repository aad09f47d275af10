"""The paper's claims, checked one by one. A new claim is one function and one line in CLAIMS."""

from __future__ import annotations

from collections.abc import Callable

from qzs_rig.claims import frequency, load, stiffness, table3, taylor
from qzs_rig.claims.verdict import Verdict

CLAIMS: dict[str, Callable[[], Verdict]] = {
    'C1': stiffness.vertical,
    'C2': stiffness.horizontal,
    'C3': taylor.deviation,
    'C4': load.capacity,
    'C5': table3.rates,
    'C6': frequency.natural,
}
