"""Runs against each other and against theory: one document, one set of tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from qzs_rig.compare.match_curves import CurveDifference, curve_differences, curve_table
from qzs_rig.compare.match_events import (
    EventDifference,
    event_difference_table,
    event_differences,
)
from qzs_rig.compare.match_theory import TheoryDifference, theory_difference, theory_table
from qzs_rig.errors import InputError
from qzs_rig.estimation.estimate import Estimate
from qzs_rig.files import number_or_none
from qzs_rig.prediction.curve import Prediction
from qzs_rig.report.table import Table

SCHEMA = 'qzs_rig/compare/1'


@dataclass(frozen=True)
class Comparison:
    """The first of `items` against every other, and all of them against theory."""

    items: tuple[str, ...]
    curves: tuple[CurveDifference, ...]
    events: tuple[EventDifference, ...]
    theory: tuple[TheoryDifference, ...]

    def to_document(self) -> dict[str, Any]:
        """A JSON-ready document (`qzs_rig/compare/1`); NaN becomes null."""
        return {
            'schema': SCHEMA,
            'items': list(self.items),
            'curves': [_plain(asdict(row)) for row in self.curves],
            'events': [_plain(asdict(row)) for row in self.events],
            'theory': [_plain(asdict(row)) for row in self.theory],
        }

    def tables(self) -> tuple[Table, ...]:
        """The same for the eye: events, curves, theory; empty ones left out."""
        tables = (
            event_difference_table(self.events),
            curve_table(self.curves),
            theory_table(self.theory),
        )
        return tuple(table.trimmed() for table in tables if table.rows)

    def to_text(self) -> str:
        """`tables` for the terminal."""
        return '\n\n'.join(table.to_text() for table in self.tables())


def compare(
    estimates: Sequence[tuple[str, Estimate]], theory: Sequence[Prediction] = ()
) -> Comparison:
    """Compare labelled `estimates`: the first is the reference of all others.

    Curves pair by degree of freedom, direction and order; direction `none` pairs with any
    direction the other lacks. Raises InputError for labels that are not distinct.
    """
    labels = [label for label, _ in estimates]
    if len(set(labels)) < len(labels):
        raise InputError(f'two items share a label: {", ".join(labels)}; name them apart')
    curves: list[CurveDifference] = []
    events: list[EventDifference] = []
    for other in estimates[1:]:
        curves.extend(curve_differences(estimates[0], other))
        events.extend(event_differences(estimates[0], other))
    against = [
        theory_difference(label, curve, prediction)
        for label, estimate in estimates
        for curve in estimate.curves
        for prediction in theory
        if prediction.dof == curve.dof
    ]
    return Comparison(tuple(labels), tuple(curves), tuple(events), tuple(against))


def _plain(row: dict[str, Any]) -> dict[str, Any]:
    """`row` with arrays as lists and every number that is not finite as null."""

    def plain(value: Any) -> Any:
        if isinstance(value, np.ndarray | tuple):
            return [plain(item) for item in value]
        if isinstance(value, float):
            return number_or_none(value)
        return value

    return {name: plain(value) for name, value in row.items()}
