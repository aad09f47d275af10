"""The paper's claims, checked one by one. A new claim is one function and one line in CLAIMS."""

from __future__ import annotations

from collections.abc import Callable

from qzs_rig.claims import at_rest, settling, transmission
from qzs_rig.claims.paper import Verdict

STATIC: dict[str, Callable[[], Verdict]] = {
    'C1': at_rest.vertical_stiffness,
    'C2': at_rest.horizontal_stiffness,
    'C3': at_rest.taylor_deviation,
    'C4': at_rest.load_capacity,
    'C5': at_rest.spring_rates,
    'C6': at_rest.natural_frequency,
}
"""Checks that take milliseconds: every report repeats them."""

DYNAMIC: dict[str, Callable[[], Verdict]] = {
    'C7': settling.damping,
    'C8': settling.length,
    'C9': settling.transients,
    'C10': transmission.damping,
    'C11': transmission.length,
    'C12': transmission.onset,
    'C13': transmission.interval,
    'C14': transmission.against_linear,
}
"""Checks that integrate and continue: seconds, on demand."""

CLAIMS = STATIC | DYNAMIC
