"""What checks of claims say: a verdict each, performed, as a table and as a document."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from qzs_rig.report.table import Table

REPRODUCED, NOT_REPRODUCED, CANNOT_TELL = 'reproduced', 'not reproduced', 'cannot tell'


class Verdict(NamedTuple):
    """One claim of the paper, checked; `figures` are numbers this check computed."""

    claim: str
    verdict: str
    figures: dict[str, float]
    how: str


def judged(holds: bool) -> str:
    """The verdict of a check that can tell."""
    return REPRODUCED if holds else NOT_REPRODUCED


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
    rows = tuple((name, v.verdict, v.claim, figures(v)) for name, v in found.items())
    header = ('id', 'verdict', 'the paper says', 'found')
    return Table('Claims of the paper', header, rows, labels=4)


def document(found: dict[str, Verdict]) -> list[dict[str, Any]]:
    """The list that --json prints."""
    return [
        {'id': name, 'claim': v.claim, 'verdict': v.verdict, 'figures': v.figures, 'how': v.how}
        for name, v in found.items()
    ]


def figures(verdict: Verdict) -> str:
    """The numbers in one line; a rounding residue is a zero."""
    items = verdict.figures.items()
    return ', '.join(f'{name}: {0 if abs(v) < 1e-14 else v:.4g}' for name, v in items)
