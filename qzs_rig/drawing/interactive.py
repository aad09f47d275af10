"""Sheets as sections of a page: one interactive plot a panel, in the look of the reports."""

from __future__ import annotations

import json
from html import escape
from typing import Any

from qzs_rig.compare.look import GRID, INK, QUIET, UNIT_LINE
from qzs_rig.drawing.sheet import Line, Panel, Sheet
from qzs_rig.drawing.still import LINE_WIDTHS, hue, one_key
from qzs_rig.files import finite_or_none
from qzs_rig.samples import Array

KEYS = {
    'broad': '▬▬',
    'solid': '━━',
    'dashed': '╌╌',
    'dotted': '┈┈',
    'marks': '●',
    'points': '··',
}
GRID_STYLE = (
    'display:grid;gap:4px 14px;grid-template-columns:repeat(auto-fit,minmax(min({}px,100%),1fr))'
)
FONT = 'system-ui, -apple-system, "Segoe UI", Roboto, "Liberation Sans", sans-serif'


def section(sheet: Sheet) -> str:
    """One card with all panels of a sheet."""
    narrow = 240 if sheet.columns > 2 else 420
    plots = ''.join(
        _plot(f'{sheet.name}-{k}', sheet, panel) for k, panel in enumerate(sheet.panels)
    )
    key = _key(sheet.panels[0].lines) if one_key(sheet) else ''
    return (
        f'<section class="card" id="{sheet.name}"><h2>{escape(sheet.title)}</h2>'
        f'<ul><li>{escape(sheet.caption)}</li></ul><figure>'
        f'<div style="{GRID_STYLE.format(narrow)}">{plots}</div>'
        f'<figcaption>{key}</figcaption></figure></section>\n'
    )


def _plot(name: str, sheet: Sheet, panel: Panel) -> str:
    drawing = {'data': [_trace(line) for line in panel.lines], 'layout': _layout(sheet, panel)}
    # "<" would end the script element; JSON may spell it as an escape
    data = json.dumps(drawing, allow_nan=False).replace('<', '\\u003c')
    said = f'{panel.title}: {panel.y_label} over {panel.x_label}'
    own_key = '' if one_key(sheet) else f'<figcaption>{_key(panel.lines)}</figcaption>'
    return (
        f'<div><h3>{escape(panel.title)}</h3>'
        f'<div class="plot" style="height:280px" role="img" aria-label="{escape(said)}" '
        f'data-name="{name}" data-figure="data-{name}"></div>'
        f'<script type="application/json" id="data-{name}">{data}</script>{own_key}</div>'
    )


def _trace(line: Line) -> dict[str, Any]:
    return {
        'type': 'scatter',
        'mode': 'markers' if line.stroke in ('marks', 'points') else 'lines',
        'marker': {'color': hue(line), 'size': 3 if line.stroke == 'points' else 6},
        'x': _numbers(line.x),
        'y': _numbers(line.y),
        'name': line.label,
        'line': {'color': hue(line), 'width': LINE_WIDTHS[line.stroke], 'dash': _dash(line)},
        'hovertemplate': '%{y:.5g}',
    }


def _layout(sheet: Sheet, panel: Panel) -> dict[str, Any]:
    axis = {
        'gridcolor': GRID,
        'zerolinecolor': UNIT_LINE,
        'linecolor': UNIT_LINE,
        'tickfont': {'color': QUIET},
        'automargin': True,
    }
    return {
        'font': {'family': FONT, 'size': 12, 'color': INK},
        'margin': {'l': 52, 'r': 8, 't': 26, 'b': 40},
        'showlegend': False,
        # unified over x would tell every fold of a curve that turns back
        'hovermode': 'closest' if panel.log else 'x unified',
        'plot_bgcolor': '#fff',
        'paper_bgcolor': '#fff',
        'xaxis': axis | _scale('x', panel) | {'title': {'text': panel.x_label, 'standoff': 6}},
        'yaxis': axis | _scale('y', panel) | {'title': {'text': panel.y_label, 'standoff': 4}},
    }


def _scale(axis: str, panel: Panel) -> dict[str, str]:
    return {'type': 'log'} if axis in panel.log else {}


def _key(lines: tuple[Line, ...]) -> str:
    return ' '.join(
        f'<span><b style="color:{hue(line)}">{KEYS[line.stroke]}</b> {escape(line.label)}</span>'
        for line in lines
        if line.label
    )


def _dash(line: Line) -> str:
    return {'dashed': '6px,3px', 'dotted': '2px,2px'}.get(line.stroke, 'solid')


def _numbers(values: Array) -> list[float | None]:
    return finite_or_none(float(f'{value:.7g}') for value in values)
