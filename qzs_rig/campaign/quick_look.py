"""A quick look at a finished campaign: lines over one axis, maps over two, dots over more."""

from __future__ import annotations

from typing import Any

import numpy as np

from qzs_rig.campaign.axes import Range
from qzs_rig.campaign.plan import Plan
from qzs_rig.campaign.sampling import Grid
from qzs_rig.campaign.table import Finished
from qzs_rig.report.sheet import HUES, Curve, Item, Panel, Points, Shades, Sheet

DOTS = 20_000
"""Points drawn at most, evenly picked: more is only darker."""
CELLS = 1000
"""Rows and columns of a map at most: a screen has no more."""


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
    numeric = all(axis.values.dtype.kind in 'fi' for axis in plan.sample.axes)
    if isinstance(plan.sample, Grid) and numeric:
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
