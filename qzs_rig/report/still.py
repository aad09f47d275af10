"""A sheet as SVG or PNG, by matplotlib."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from qzs_rig.errors import InputError
from qzs_rig.report.sheet import (
    GRID,
    INK,
    MARKS,
    QUIET,
    RULE,
    Band,
    Curve,
    Panel,
    Points,
    Regions,
    Shades,
    Sheet,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WIDTHS = {1: 7.2, 2: 4.8, 3: 4.2}
"""Inches of a column, by the number of columns; 3.4 where there are more."""
DASHES: dict[str, Any] = {'solid': '-', 'dashed': (0, (5, 2)), 'dotted': (0, (1.2, 1.4))}
MANY = 2000
"""More points than this weigh too much as vectors, and are drawn smaller."""


def still(sheet: Sheet, kind: str) -> bytes:
    """The picture of a sheet, `kind` svg or png; the same sheet gives the same bytes.

    Raises InputError where matplotlib is not installed.
    """
    try:
        from matplotlib import rc_context
        from matplotlib.figure import Figure
    except ImportError as error:
        raise InputError(
            'a picture needs the package matplotlib; install it with: pip install matplotlib'
        ) from error
    # a fixed salt: the ids inside an SVG are random otherwise
    with rc_context({'font.size': 9.0, 'svg.fonttype': 'path', 'svg.hashsalt': 'qzs_rig'}):
        figure = Figure(layout='constrained')
        figure.suptitle(_plain(sheet.title), color=INK, x=0.01, ha='left', fontsize=11.0)
        _draw(figure, sheet)
        page = io.BytesIO()
        stamp: dict[str, Any] = {'Date': None} if kind == 'svg' else {'Software': None}
        figure.savefig(page, format=kind, dpi=150, metadata=stamp)
    return page.getvalue()


def _draw(figure: Any, sheet: Sheet) -> None:
    columns = sheet.columns
    rows = -(-len(sheet.panels) // columns)
    heights = [panel.height for panel in sheet.panels[::columns]]
    width = WIDTHS.get(columns, 3.4)
    figure.set_size_inches(width * columns, 0.72 * width * sum(heights) + 0.9)
    share = 'col' if sheet.linked else False
    axes = figure.subplots(rows, columns, squeeze=False, sharex=share, height_ratios=heights)
    below = sheet.one_key and not sheet.linked and len(sheet.panels) > 1
    for k, (place, panel) in enumerate(zip(axes.flat, sheet.panels, strict=False)):
        last_row = k >= len(sheet.panels) - columns
        _panel(place, panel, x_label=last_row or not sheet.linked)
        handles = _handles(place)
        if handles and not below and (not sheet.linked or k < columns):
            solid = any(isinstance(item, Regions) for item in panel.items)
            place.legend(*handles, frameon=solid, framealpha=0.9, fontsize=8.0)
    for place in axes.flat[len(sheet.panels) :]:
        place.set_axis_off()
    if below and (handles := _handles(axes.flat[0])):
        figure.legend(*handles, loc='outside lower center', ncols=4, frameon=False)


def _panel(axes: Axes, panel: Panel, x_label: bool) -> None:
    for item in panel.items:
        DRAW[type(item)](axes, item)
    _scales(axes, panel)
    _guides(axes, panel)
    axes.set_title(_plain(panel.title), loc='left', color=INK, fontsize=9.0)
    axes.set_ylabel(panel.y_label)
    if x_label:
        axes.set_xlabel(panel.x_label)
    axes.tick_params(colors=QUIET)
    for spine in axes.spines.values():
        spine.set_color(RULE)


def _scales(axes: Axes, panel: Panel) -> None:
    axes.margins(x=0.0)
    for name, span in (('x', panel.x_range), ('y', panel.y_range)):
        if name in panel.log:
            axes.set(**{f'{name}scale': 'log'})
        if span is not None:
            axes.set(**{f'{name}lim': span})
        if name in panel.log:
            _plain_ticks(getattr(axes, f'{name}axis'))
    if panel.y_step is not None:
        from matplotlib.ticker import MultipleLocator

        axes.yaxis.set_major_locator(MultipleLocator(panel.y_step))


def _plain_ticks(axis: Any) -> None:
    """Plain numbers at 1, 2 and 5 of a decade; at its powers alone where there are many."""
    from matplotlib.ticker import LogLocator, NullFormatter

    low, high = axis.get_view_interval()
    if high < 1e3 * low:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter('{x:g}')
    axis.set_minor_formatter(NullFormatter())


def _guides(axes: Axes, panel: Panel) -> None:
    """Grid, the axes through 0, and the level."""
    if any(isinstance(item, Regions | Shades) for item in panel.items):
        return
    axes.grid(True, color=GRID, linewidth=0.8)
    axes.set_axisbelow(True)
    for span, log, line in (
        (axes.get_xlim(), 'x' in panel.log, axes.axvline),
        (axes.get_ylim(), 'y' in panel.log, axes.axhline),
    ):
        if not log and span[0] < 0.0 < span[1]:
            line(0.0, color=RULE, linewidth=0.8, zorder=0)
    if panel.level is not None:
        axes.axhline(panel.level, color=RULE, linestyle=':', linewidth=1.2, zorder=0)


def _curve(axes: Axes, item: Curve) -> None:
    style = {'color': item.colour, 'linewidth': item.width, 'linestyle': DASHES[item.stroke]}
    axes.plot(item.x, item.y, label=_plain(item.label), **style)


def _points(axes: Axes, item: Points) -> None:
    many = len(item.x) > MANY
    style: dict[str, Any] = {
        'color': item.colour,
        'linestyle': '',
        'marker': MARKS[item.mark].matplotlib,
        'markersize': min(item.size, 1.2) if many else item.size,
        'rasterized': many,
    }
    if item.hollow:
        style |= {'markerfacecolor': 'white', 'markeredgewidth': 1.6, 'clip_on': False, 'zorder': 5}
    elif item.mark == 'dot':
        style |= {'markeredgewidth': 0.0}
    axes.plot(item.x, item.y, **style)
    key = style | {'markersize': max(item.size, 4.5), 'clip_on': True}
    axes.plot([], [], label=_plain(item.label), **key)


def _band(axes: Axes, item: Band) -> None:
    style: dict[str, Any] = {'color': item.colour, 'alpha': 0.2, 'linewidth': 0.0}
    axes.fill_between(item.x, item.low, item.high, label=_plain(item.label), **style)


def _regions(axes: Axes, item: Regions) -> None:
    from matplotlib.colors import to_rgb

    picture = np.ones((*item.which.shape, 3))
    for number, (name, colour) in item.names.items():
        picture[item.which == number] = to_rgb(colour)
        axes.plot([], [], linestyle='', marker='s', color=colour, label=_plain(name))
    extent = (item.x[0], item.x[-1], item.y[0], item.y[-1])
    axes.imshow(picture, extent=extent, origin='lower', aspect='auto', interpolation='nearest')


def _shades(axes: Axes, item: Shades) -> None:
    if item.values.ndim == 2:
        shown: Any = axes.pcolormesh(item.x, item.y, item.values)
    else:
        shown = axes.scatter(item.x, item.y, c=item.values, s=6.0)
    axes.figure.colorbar(shown, ax=axes)


DRAW: dict[type, Callable[[Axes, Any], None]] = {
    Curve: _curve,
    Points: _points,
    Band: _band,
    Regions: _regions,
    Shades: _shades,
}


def _handles(axes: Axes) -> tuple[Sequence[Any], Sequence[str]] | None:
    """Each label once, by the first thing that carries it; None where nothing is named."""
    named: dict[str, Any] = {}
    for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
        named.setdefault(label, handle)
    return (list(named.values()), list(named)) if named else None


def _plain(text: str) -> str:
    """`text` without matplotlib's markup: dollars would be mathematics, a leading _ hides it."""
    return ' ' * text.startswith('_') + text.replace('$', r'\$')
