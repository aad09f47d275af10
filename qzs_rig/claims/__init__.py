"""The paper's claims, checked one by one. A new claim is one function and one line in CLAIMS."""

from __future__ import annotations

from collections.abc import Callable

from qzs_rig.claims import (
    frequency,
    load,
    settling,
    stiffness,
    sweeps,
    table3,
    taylor,
    transmission,
)
from qzs_rig.claims.verdict import Verdict

STATIC: dict[str, Callable[[], Verdict]] = {
    'C1': stiffness.vertical,
    'C2': stiffness.horizontal,
    'C3': taylor.deviation,
    'C4': load.capacity,
    'C5': table3.rates,
    'C6': frequency.natural,
}
"""Checks that take milliseconds: every report repeats them."""

DYNAMIC: dict[str, Callable[[], Verdict]] = {
    'C7': settling.damping,
    'C8': settling.length,
    'C9': settling.transients,
    'C10': transmission.damping,
    'C11': transmission.length,
    'C12': transmission.onset,
    'C13': sweeps.interval,
    'C14': sweeps.against_linear,
}
"""Checks that integrate and continue: seconds, on demand."""

CLAIMS = STATIC | DYNAMIC
