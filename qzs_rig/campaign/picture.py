"""A quick look at a finished campaign: lines over one axis, maps over two, dots over more."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from qzs_rig.campaign.axes import Range
from qzs_rig.campaign.plan import Plan
from qzs_rig.campaign.sampling import Grid
from qzs_rig.campaign.table import Finished
from qzs_rig.compare.look import GRID, INK, QUIET, UNIT_LINE, hue

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DOTS = 20_000
"""Points drawn at most, evenly picked: more is only darker."""
WIDTH, HEIGHT = 4.4, 2.7
BLUE = hue(0, 'forward')


def quick_look(plan: Plan, table: Finished, title: str) -> bytes:
    """PNG with a panel an output (with dots: a row an output, a column an axis).

    Raises ImportError where matplotlib is not installed.
    """
    from matplotlib.figure import Figure

    outputs = [name for name in plan.task.columns if np.isfinite(table.column(name)).any()]
    panels = _panels(plan, table, outputs or list(plan.task.columns[:1]))
    columns = min(len(panels), len(plan.varied) if len(plan.varied) > 2 else 3)
    rows = -(-len(panels) // columns)
    figure = Figure(figsize=(WIDTH * columns, HEIGHT * rows + 0.5), layout='constrained')
    figure.suptitle(title, color=INK, x=0.01, ha='left', fontsize=11.0)
    places = figure.subplots(rows, columns, squeeze=False).ravel()
    for place, panel in zip(places, panels, strict=False):
        panel(place)
        _dress(place)
    for place in places[len(panels) :]:
        place.set_axis_off()
    page = io.BytesIO()
    figure.savefig(page, format='png', dpi=110, metadata={'Software': None})
    return page.getvalue()


def _panels(plan: Plan, table: Finished, outputs: list[str]) -> list[Callable[[Axes], None]]:
    if len(plan.varied) == 2 and isinstance(plan.sample, Grid) and _numeric(plan, table):
        return [_map(plan, table, name, plan.sample.shape) for name in outputs]
    if len(plan.varied) == 2:
        return [_coloured(plan, table, name) for name in outputs]
    return [_over(plan, table, name, axis) for name in outputs for axis in range(len(plan.varied))]


def _numeric(plan: Plan, table: Finished) -> bool:
    return all(axis.values.dtype.kind in 'fi' for axis in plan.sample.axes)


def _map(plan: Plan, table: Finished, name: str, shape: tuple[int, ...]) -> Callable[[Axes], None]:
    """One output as colour over two axes; its rows are thinned to what a screen has."""

    def draw(place: Axes) -> None:
        y, x = (axis.values for axis in plan.sample.axes)
        z = table.column(name).reshape(shape)
        thin = tuple(slice(None, None, -(-size // 1000)) for size in shape)
        order = np.argsort(y[thin[0]]), np.argsort(x[thin[1]])
        values = z[thin][np.ix_(*order)]
        mesh = place.pcolormesh(x[thin[1]][order[1]], y[thin[0]][order[0]], values)
        place.figure.colorbar(mesh, ax=place)
        place.set_title(name, loc='left', color=INK, fontsize=9.0)
        _scale(place, plan, x=1, y=0)

    return draw


def _coloured(plan: Plan, table: Finished, name: str) -> Callable[[Axes], None]:
    """One output as the colour of dots over two axes."""

    def draw(place: Axes) -> None:
        y, x = (_places(table.column(axis)) for axis in plan.varied)
        pick = _some(plan)
        dots = place.scatter(x[pick], y[pick], c=table.column(name)[pick], s=6.0)
        place.figure.colorbar(dots, ax=place)
        place.set_title(name, loc='left', color=INK, fontsize=9.0)
        _scale(place, plan, x=1, y=0)

    return draw


def _over(plan: Plan, table: Finished, name: str, axis: int) -> Callable[[Axes], None]:
    """One output over one axis: a line where it is the only one, else dots."""

    def draw(place: Axes) -> None:
        pick = _some(plan)
        x, y = table.column(plan.varied[axis])[pick], table.column(name)[pick]
        line = len(plan.varied) == 1 and isinstance(plan.sample, Grid)
        marker: dict[str, Any] = {'marker': '.', 'markersize': 3.0}
        place.plot(x, y, color=BLUE, linestyle='-' if line else 'none', linewidth=1.0, **marker)
        place.set_ylabel(name)
        _scale(place, plan, x=axis)

    return draw


def _scale(place: Axes, plan: Plan, x: int, y: int | None = None) -> None:
    for number, label, scale in (
        (x, place.set_xlabel, place.set_xscale),
        (y, place.set_ylabel, place.set_yscale),
    ):
        if number is not None:
            axis = plan.sample.axes[number]
            unit = axis.parameter.unit
            label(f'{axis.parameter.name} ({unit})' if unit else axis.parameter.name)
            if isinstance(axis, Range) and axis.scale == 'log':
                scale('log')


def _some(plan: Plan) -> slice:
    return slice(None, None, -(-plan.points // DOTS))


def _places(column: Any) -> Any:
    """Words as numbers, in alphabetical order."""
    return column if column.dtype.kind in 'fi' else np.unique(column, return_inverse=True)[1]


def _dress(place: Axes) -> None:
    place.grid(True, color=GRID, linewidth=0.6)
    place.set_axisbelow(True)
    place.tick_params(colors=QUIET)
    for spine in place.spines.values():
        spine.set_color(UNIT_LINE)
