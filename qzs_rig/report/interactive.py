"""Sheets as plots to explore in a page, by Bokeh."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

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

Plot = Any
"""A Bokeh figure: Bokeh is imported where a page is written."""

FONT = 'system-ui, -apple-system, "Segoe UI", Roboto, "Liberation Sans", sans-serif'
HEIGHT, LINKED_HEIGHT = 290, 640
"""Pixels of a panel of height 1, alone and in a column of linked ones."""
LEFT = 84
"""Pixels left of the axes, so that those of a column stand below each other."""
DASHES: dict[str, Any] = {'solid': 'solid', 'dashed': [6, 3], 'dotted': [2, 2]}
PIXELS = 96 / 72
"""A pixel is this part of a point of print."""


def drawing(sheets: Sequence[Sheet]) -> dict[str, Any]:
    """What the page's script hands to `Bokeh.embed.embed_items`: the document of all panels, and
    the place of each. The same sheets give the same document."""
    from bokeh.document import Document

    document = Document()
    places = []
    for sheet in sheets:
        for place, plot in zip(place_ids(sheet), _plots(sheet), strict=True):
            document.add_root(plot)
            places.append(place)
    plain = _renumbered(document.to_json(deferred=False), {})
    roots = {root['id']: place for root, place in zip(plain['roots'], places, strict=True)}
    item = {'docid': 'page', 'roots': roots, 'root_ids': list(roots)}
    return {'documents': {'page': plain}, 'items': [item]}


def place_ids(sheet: Sheet) -> list[str]:
    """The id of the element of each panel."""
    return [f'{sheet.name}-{k}' for k in range(len(sheet.panels))]


def javascript() -> str:
    """BokehJS as installed, spelt so that no string in it ends a script element and with the line
    ends that a browser hashes. Raises InputError where Bokeh is not installed."""
    try:
        from bokeh.resources import Resources
    except ImportError as error:
        raise InputError(
            'a report needs the package bokeh; install it with: pip install bokeh'
        ) from error
    # what follows the first sets a log level, and says so on the console
    library = Resources(mode='inline', components=['bokeh']).js_raw[0]
    return library.replace('\r\n', '\n').replace('</script', r'<\/script')


def _plots(sheet: Sheet) -> list[Plot]:
    plots: list[Plot] = []
    for k, panel in enumerate(sheet.panels):
        plot = _plot(panel, *((LINKED_HEIGHT, LEFT) if sheet.linked else (HEIGHT, 0)))
        if sheet.columns > 2 and 'x' not in panel.log:
            # narrow: more labels would run into each other
            plot.xaxis.ticker.desired_num_ticks = 4
        if sheet.linked and k >= sheet.columns:
            plot.x_range = plots[k - sheet.columns].x_range
            plot.toolbar_location = None
        if sheet.linked and k < len(sheet.panels) - sheet.columns:
            plot.xaxis.axis_label = ''
        plots.append(plot)
    return plots


def _plot(panel: Panel, height: float, left: int) -> Plot:
    from bokeh.plotting import figure

    plot = figure(
        height=round(height * panel.height),
        sizing_mode='stretch_width',
        min_border_left=left,
        min_border_right=12,
        x_axis_type='log' if 'x' in panel.log else 'linear',
        y_axis_type='log' if 'y' in panel.log else 'linear',
        x_axis_label=panel.x_label,
        y_axis_label=panel.y_label,
        tools='box_zoom,pan,wheel_zoom,save,reset',
        active_drag='box_zoom',
        toolbar_location='above',
        outline_line_color=RULE,
    )
    plot.toolbar.logo = None
    plot.toolbar.autohide = True
    spoken: dict[bool, list[Any]] = {}
    for item in panel.items:
        renderer = DRAW[type(item)](plot, item)
        if isinstance(item, Curve | Points):
            spoken.setdefault(bool(item.notes), []).append(renderer)
    plot.add_tools(*(_hover(panel, found, notes) for notes, found in spoken.items()))
    _dress(plot, panel)
    return plot


def _dress(plot: Plot, panel: Panel) -> None:
    from bokeh.models import FixedTicker, PrintfTickFormatter, Range1d
    from bokeh.models.annotations import Span

    for axis in plot.axis:
        axis.axis_label_text_font = axis.major_label_text_font = FONT
        axis.axis_label_text_font_style = 'normal'
        axis.axis_label_text_font_size, axis.major_label_text_font_size = '13px', '12px'
        axis.axis_label_text_color, axis.major_label_text_color = INK, QUIET
        axis.axis_line_color = axis.major_tick_line_color = axis.minor_tick_line_color = RULE
    plot.grid.grid_line_color = GRID
    for name, axis, grid in (('x', plot.xaxis, plot.xgrid), ('y', plot.yaxis, plot.ygrid)):
        span = panel.span(name)
        setattr(plot, f'{name}_range', Range1d(start=span[0], end=span[1]))
        if name in panel.log:
            axis.ticker = grid.ticker = _log_ticker(*span)
            axis.formatter = PrintfTickFormatter(format='%g')
        else:
            axis.minor_tick_line_color = None
    if panel.y_step is not None:
        low, high = (edge / panel.y_step for edge in panel.span('y'))
        ticks = (panel.y_step * np.arange(np.ceil(low), np.floor(high) + 1)).tolist()
        plot.yaxis.ticker = plot.ygrid.ticker = FixedTicker(ticks=ticks)
    if panel.level is not None:
        style: dict[str, Any] = {'line_color': RULE, 'line_dash': 'dotted', 'level': 'underlay'}
        plot.add_layout(Span(location=panel.level, **style))


def _log_ticker(low: float, high: float) -> Any:
    """Ticks at 1, 2 and 5 of a decade; at every digit below one decade, at powers above three."""
    from bokeh.models import FixedTicker

    bottom, top = np.log10(low), np.log10(high)
    many, few = top - bottom < 0.9, top - bottom > 3.0
    named = range(1, 10) if many else (1,) if few else (1, 2, 5)
    powers = range(int(np.floor(bottom)) - 2, int(np.ceil(top)) + 2)
    every = [(digit, digit * 10.0**power) for power in powers for digit in range(1, 10)]
    return FixedTicker(
        ticks=[value for digit, value in every if digit in named],
        minor_ticks=[value for _, value in every],
    )


def _hover(panel: Panel, renderers: list[Any], notes: bool) -> Any:
    """What is said at a point: whose it is, its numbers, its note; escaped by Bokeh."""
    from bokeh.models import HoverTool

    tooltips = [('', '$name'), (panel.x_label, '@x{%.5g}'), (panel.y_label, '@y{%.5g}')]
    return HoverTool(
        renderers=renderers,
        tooltips=tooltips + ([('', '@note')] if notes else []),
        formatters={'@x': 'printf', '@y': 'printf'},
        visible=False,
        limit=1,
    )


def _added(plot: Plot, item: Curve | Points, glyph: Any) -> Any:
    from bokeh.models import ColumnDataSource

    columns: dict[str, Any] = {'x': _short(item.x), 'y': _short(item.y)}
    source = ColumnDataSource(columns | ({'note': list(item.notes)} if item.notes else {}))
    # one glyph: `plot.line` and the like make two more for a selection, which nothing here has
    return plot.add_glyph(source, glyph, name=item.label)


def _short(values: Any) -> Any:
    """Seven digits are more than a screen shows."""
    return np.asarray(values, dtype=np.float32)


def _curve(plot: Plot, item: Curve) -> Any:
    from bokeh.models import Line

    style: dict[str, Any] = {'line_color': item.colour, 'line_width': item.width}
    return _added(plot, item, Line(x='x', y='y', line_dash=DASHES[item.stroke], **style))


def _points(plot: Plot, item: Points) -> Any:
    from bokeh.models import Scatter

    mark = MARKS[item.mark]
    style: dict[str, Any] = {'marker': mark.bokeh, 'angle': mark.turn, 'angle_units': 'deg'}
    style |= {'line_color': item.colour, 'size': PIXELS * item.size}
    style |= (
        {'fill_color': 'white', 'line_width': 2.2}
        if item.hollow
        else {'fill_color': item.colour, 'line_width': 0.0}
    )
    return _added(plot, item, Scatter(x='x', y='y', **style))


def _band(plot: Plot, item: Band) -> None:
    style = {'name': item.label, 'fill_color': item.colour, 'fill_alpha': 0.2}
    plot.varea(_short(item.x), _short(item.low), _short(item.high), **style)


def _regions(plot: Plot, item: Regions) -> None:
    x, y = float(item.x[0]), float(item.y[0])
    place = {'x': x, 'y': y, 'dw': float(item.x[-1]) - x, 'dh': float(item.y[-1]) - y}
    for number, (name, colour) in item.names.items():
        red, green, blue = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
        solid = 0xFF000000 | blue << 16 | green << 8 | red
        picture = np.where(item.which == number, np.uint32(solid), np.uint32(0))
        plot.image_rgba(image=[picture], name=name, **place)


def _shades(plot: Plot, item: Shades) -> None:
    from bokeh.models import ColumnDataSource
    from bokeh.models.annotations import ColorBar
    from bokeh.palettes import Viridis256
    from bokeh.transform import linear_cmap

    x, y = np.meshgrid(item.x, item.y) if item.values.ndim == 2 else (item.x, item.y)
    values = item.values.ravel()
    colour = linear_cmap('values', Viridis256, float(np.nanmin(values)), float(np.nanmax(values)))
    data = {'x': _short(x.ravel()), 'y': _short(y.ravel()), 'values': _short(values)}
    source = ColumnDataSource(data)
    plot.scatter('x', 'y', source=source, marker='square', color=colour, size=6)
    plot.add_layout(ColorBar(color_mapper=colour['transform']), 'right')


DRAW: dict[type, Callable[[Plot, Any], Any]] = {
    Curve: _curve,
    Points: _points,
    Band: _band,
    Regions: _regions,
    Shades: _shades,
}


def _renumbered(value: Any, known: dict[str, str]) -> Any:
    """The document with models counted from 1: Bokeh goes on counting over all documents."""
    if isinstance(value, list):
        return [_renumbered(item, known) for item in value]
    if isinstance(value, dict):
        return {
            name: known.setdefault(item, f'p{len(known) + 1}')
            if name == 'id'
            else _renumbered(item, known)
            for name, item in value.items()
        }
    return value
