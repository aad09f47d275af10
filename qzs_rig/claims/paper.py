"""The paper's platform, and the verdict on one of its claims."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import PAPER_DESIGN
from qzs_rig.report.table import Table
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import TRANSLATIONS

K1, PAYLOAD = 20000.0, 50.0
"""Table 1, N/m and kg."""
L20, BASE = 0.6, 0.1
"""Table 1, m: length, and amplitude H of the base."""
OMEGA0 = 20.0
"""sqrt(k1/m) of Table 1, rad/s."""
AMPLITUDE, TURN = 0.6, math.radians(5.0)
"""Ĥ of its figures, and what takes its place for rotations, rad."""
ZETA = 0.07
ZETAS = (0.0158, ZETA, 0.158)


def paper_oscillator(dof: str, zeta: float = ZETA, law: str = 'corrected') -> Oscillator:
    """A degree of freedom of the paper's platform under its base amplitude."""
    amplitude = AMPLITUDE if dof in TRANSLATIONS else TURN
    return Oscillator(RESTORING[law], dof, PAPER_DESIGN, zeta, amplitude)


class Verdict(NamedTuple):
    """One claim of the paper, checked: whether it `holds`, the numbers that this check computed,
    and how."""

    claim: str
    holds: bool
    figures: dict[str, float]
    how: str

    @property
    def text(self) -> str:
        """'reproduced' or 'not reproduced'."""
        return 'reproduced' if self.holds else 'not reproduced'

    @property
    def numbers(self) -> str:
        """`figures` in one line; a rounding residue is a zero."""
        items = self.figures.items()
        return ', '.join(f'{name}: {0 if abs(v) < 1e-14 else v:.4g}' for name, v in items)


def verdicts(
    claims: Mapping[str, Callable[[], Verdict]], progress: Callable[[str], object] = str
) -> dict[str, Verdict]:
    """The checks of `claims`, performed; `progress` hears the name of each before it starts."""
    found = {}
    for name, check in claims.items():
        progress(name)
        found[name] = check()
    return found


def table(found: dict[str, Verdict]) -> Table:
    """One row a claim, for report and terminal."""
    rows = tuple((name, v.text, v.claim, v.numbers) for name, v in found.items())
    header = ('id', 'verdict', 'the paper says', 'found')
    return Table('Claims of the paper', header, rows, labels=4)


def document(found: dict[str, Verdict]) -> list[dict[str, Any]]:
    """The list that --json prints."""
    return [
        {'id': name, 'claim': v.claim, 'verdict': v.text, 'figures': v.figures, 'how': v.how}
        for name, v in found.items()
    ]
