"""Reading a finished table: its columns, a summary, and a quick look as lines, maps or dots."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from qzs_rig.campaign.axes import Column, Range
from qzs_rig.campaign.plan import Plan
from qzs_rig.campaign.sampling import Grid
from qzs_rig.files import number_or_none
from qzs_rig.report.sheet import HUES, Curve, Item, Panel, Points, Shades, Sheet
from qzs_rig.report.table import Table, number

SCHEMA = 'qzs_rig/campaign/1'
SHOWN = 5
"""Reasons named in the text of a summary; the document has them all."""
DOTS = 20_000
"""Points drawn at most, evenly picked: more is only darker."""
CELLS = 1000
"""Rows and columns of a map at most: a screen has no more."""


@dataclass(frozen=True)
class Finished:
    """A table on the disk; columns are read one at a time."""

    path: Path

    @property
    def about(self) -> dict[str, Any]:
        """Plan, version, and unit and text of every column."""
        if self.path.suffix == '.npz':
            with np.load(self.path) as file:
                return dict(json.loads(str(file['about'])))
        from pyarrow import parquet

        metadata = parquet.read_schema(self.path).metadata
        return dict(json.loads(metadata[b'qzs_rig']))

    def column(self, name: str) -> Column:
        """All values of a column, one a point."""
        if self.path.suffix == '.npz':
            with np.load(self.path) as file:
                return np.asarray(file[name])
        return np.asarray(self._arrow(name).to_numpy())

    def failures(self) -> dict[str, int]:
        """How many rows failed, by reason, most frequent first."""
        if self.path.suffix == '.npz':
            with np.load(self.path) as file:
                words, counts = file['reasons'], np.bincount(file['reason'])
            pairs = list(zip(words.tolist(), counts.tolist(), strict=False))
        else:
            counted = self._arrow('reason').value_counts().to_pylist()
            pairs = [(c['values'], c['counts']) for c in counted]
        failed = {reason: count for reason, count in pairs if reason and count}
        return dict(sorted(failed.items(), key=lambda item: (-item[1], item[0])))

    def _arrow(self, name: str) -> Any:
        from pyarrow import parquet

        return parquet.read_table(self.path, columns=[name]).column(name)


def summary(table: Finished) -> dict[str, Any]:
    """How each output spreads over the points where it is a number, and how many points failed,
    by reason; JSON-ready. Reads a column at a time."""
    about, failures = table.about, table.failures()
    outputs = {
        name: {'unit': output['unit'], **_spread(table.column(name))}
        for name, output in about['outputs'].items()
    }
    return {
        'schema': SCHEMA,
        'points': about['points'],
        'failed': sum(failures.values()),
        'failures': failures,
        'outputs': outputs,
    }


def _spread(values: Column) -> dict[str, Any]:
    values = values[np.isfinite(values)]
    figures = (np.min(values), np.median(values), np.max(values)) if values.size else (np.nan,) * 3
    low, median, high = map(number_or_none, figures)
    return {'numbers': values.size, 'min': low, 'median': median, 'max': high}


def summary_text(found: dict[str, Any]) -> str:
    """A `summary` as the table that a user reads, and the most frequent reasons."""
    header = ('output', 'unit', 'numbers', 'min', 'median', 'max')
    rows = tuple(
        (name, o['unit'], str(o['numbers']), *(number(o[figure], '.6g') for figure in header[3:]))
        for name, o in found['outputs'].items()
    )
    caption = f'{found["points"]} points, {found["failed"]} failed'
    lines = [Table(caption, header, rows).to_text()]
    reasons = list(found['failures'].items())
    lines += [f'failed   {count} points: {reason}' for reason, count in reasons[:SHOWN]]
    if len(reasons) > SHOWN:
        lines.append(f'         and for {len(reasons) - SHOWN} more reasons')
    return '\n'.join(lines)


def quick_look(plan: Plan, table: Finished, title: str) -> Sheet:
    """A panel an output (with dots: a row an output, a column an axis)."""
    outputs = [name for name in plan.task.columns if np.isfinite(table.column(name)).any()]
    outputs = outputs or list(plan.task.columns[:1])
    if len(plan.varied) == 2:
        panels = [_coloured(plan, table, name) for name in outputs]
    else:
        axes = range(len(plan.varied))
        panels = [_over(plan, table, name, axis) for name in outputs for axis in axes]
    columns = min(len(panels), len(plan.varied) if len(plan.varied) > 2 else 3)
    return Sheet('quick_look', title, '', tuple(panels), columns)


def _coloured(plan: Plan, table: Finished, name: str) -> Panel:
    """One output as colour over two axes: a map of a grid, else dots."""
    if isinstance(plan.sample, Grid) and all(a.values.dtype.kind in 'fi' for a in plan.sample.axes):
        item = _map(plan, table.column(name).reshape(plan.sample.shape))
    else:
        pick = _some(plan)
        y, x = (_places(table.column(axis))[pick] for axis in plan.varied)
        item = Shades(x, y, table.column(name)[pick])
    log = 'x' * _logarithmic(plan, 1) + 'y' * _logarithmic(plan, 0)
    return Panel(name, _axis_label(plan, 1), _axis_label(plan, 0), (item,), log)


def _map(plan: Plan, values: Any) -> Shades:
    y, x = (axis.values[:: -(-len(axis.values) // CELLS)] for axis in plan.sample.axes)
    thin = values[tuple(slice(None, None, -(-size // CELLS)) for size in values.shape)]
    rows, columns = np.argsort(y), np.argsort(x)
    return Shades(x[columns], y[rows], thin[np.ix_(rows, columns)])


def _over(plan: Plan, table: Finished, name: str, axis: int) -> Panel:
    """One output over one axis: a line where it is the only one, and dots."""
    pick = _some(plan)
    x, y = _places(table.column(plan.varied[axis]))[pick], table.column(name)[pick]
    items: list[Item] = [Points('', x, y, size=2.0)]
    if len(plan.varied) == 1 and isinstance(plan.sample, Grid):
        items.append(Curve('', x, y, HUES[0], width=1.0))
    log = 'x' * _logarithmic(plan, axis)
    return Panel('', _axis_label(plan, axis), name, tuple(items), log)


def _axis_label(plan: Plan, number: int) -> str:
    parameter = plan.sample.axes[number].parameter
    return f'{parameter.name} ({parameter.unit})' if parameter.unit else parameter.name


def _logarithmic(plan: Plan, number: int) -> bool:
    axis = plan.sample.axes[number]
    return isinstance(axis, Range) and axis.scale == 'log'


def _some(plan: Plan) -> slice:
    return slice(None, None, -(-plan.points // DOTS))


def _places(column: Any) -> Any:
    """Words as numbers, in alphabetical order."""
    return column if column.dtype.kind in 'fi' else np.unique(column, return_inverse=True)[1]
