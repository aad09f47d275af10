"""A finished campaign in a few figures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from qzs_rig.campaign.ledger import SCHEMA
from qzs_rig.campaign.table import Finished
from qzs_rig.files import number_or_none
from qzs_rig.report.table import Table, number

SHOWN = 5
"""Reasons named in the text; the document has them all."""


@dataclass(frozen=True)
class Spread:
    """An output over the points where it is a number; NaN where it is none anywhere."""

    name: str
    unit: str
    numbers: int
    low: float
    median: float
    high: float


@dataclass(frozen=True)
class Summary:
    """How each output spreads, and how many points failed, by reason."""

    points: int
    spreads: tuple[Spread, ...]
    failures: dict[str, int]

    @property
    def failed(self) -> int:
        """Points without figures."""
        return sum(self.failures.values())

    def document(self) -> dict[str, Any]:
        """JSON-ready; a figure that is none is null."""
        return {
            'schema': SCHEMA,
            'points': self.points,
            'failed': self.failed,
            'failures': self.failures,
            'outputs': {
                s.name: {
                    'unit': s.unit,
                    'numbers': s.numbers,
                    'min': number_or_none(s.low),
                    'median': number_or_none(s.median),
                    'max': number_or_none(s.high),
                }
                for s in self.spreads
            },
        }

    def text(self) -> str:
        """The table that a user reads, and the reasons."""
        rows = tuple(
            (s.name, s.unit, str(s.numbers), *(number(v, '.6g') for v in (s.low, s.median, s.high)))
            for s in self.spreads
        )
        header = ('output', 'unit', 'numbers', 'min', 'median', 'max')
        lines = [Table(f'{self.points} points, {self.failed} failed', header, rows).to_text()]
        listed = list(self.failures.items())
        lines += [f'failed   {count} points: {reason}' for reason, count in listed[:SHOWN]]
        if len(listed) > SHOWN:
            lines.append(f'         and for {len(listed) - SHOWN} more reasons')
        return '\n'.join(lines)


def summary(table: Finished) -> Summary:
    """Read a table once, a column at a time."""
    told = table.about
    spreads = tuple(_spread(table, name, o['unit']) for name, o in told['outputs'].items())
    return Summary(told['points'], spreads, table.failures())


def _spread(table: Finished, name: str, unit: str) -> Spread:
    values = table.column(name)
    values = values[np.isfinite(values)]
    if not values.size:
        return Spread(name, unit, 0, np.nan, np.nan, np.nan)
    figures = (float(f(values)) for f in (np.min, np.median, np.max))
    return Spread(name, unit, values.size, *figures)
