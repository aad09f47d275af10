"""The interactive figure of one degree of freedom: a plotly document, built without plotly."""

from __future__ import annotations

import math
from collections.abc import Sequence

from qzs_rig.compare.look import (
    ARROWS,
    GRID,
    INK,
    QUIET,
    UNIT_LINE,
    event_mark,
    hue,
    line_width,
    theory_hue,
)
from qzs_rig.compare.panels import (
    Labelled,
    Ranges,
    Shown,
    arrow_indices,
    phase_line,
    ranges,
    shown,
)
from qzs_rig.compare.theory_traces import point_texts, theory_traces
from qzs_rig.compare.traces import Document, escaped, hover
from qzs_rig.files import finite_or_none, number_or_none
from qzs_rig.prediction.curve import Prediction
from qzs_rig.report.names import direction_name, event_name

MANY_POINTS = 150
"""Above this, points melt into a line and only the direction arrows are marked."""


def figure(dof: str, estimates: Labelled, theory: Sequence[Prediction]) -> Document:
    """`data` and `layout` for Plotly.newPlot: magnitude over phase over THD, one frequency axis.

    Text from outside is escaped for plotly's own markup; numbers that are not finite are null.
    """
    curves = shown(dof, estimates)
    predictions = [curve for curve in theory if curve.dof == dof]
    view = ranges([item.curve for item in curves], predictions)
    several = len(estimates) > 1
    traces: list[Document] = []
    for item in curves:
        texts = point_texts(item.curve, predictions)
        traces += _curve_traces(item, several, view.thd_percent is not None, texts)
    # Thin and on top: a good measurement would hide it.
    for k, prediction in enumerate(predictions):
        traces += theory_traces(prediction, theory_hue(k))
    return {'data': traces, 'layout': _layout(view)}


def _curve_traces(item: Shown, several: bool, with_thd: bool, texts: list[str]) -> list[Document]:
    curve = item.curve
    colour, words = hue(item.item, curve.direction), direction_name(curve.direction)
    name = escaped(f'{item.label}, {words}' if several else words)
    style: Document = {
        'type': 'scatter',
        'name': name,
        'legendgroup': f'{item.item} {name}',
        'line': {'color': colour, 'width': line_width(curve.direction)},
    }
    phase = phase_line(curve)
    quiet = {'mode': 'lines', 'showlegend': False}
    traces = [
        style
        | {'x': finite_or_none(curve.frequency_hz), 'y': finite_or_none(curve.magnitude)}
        | {'mode': 'lines+markers', 'marker': _markers(item, colour)}
        | {'hovertemplate': hover('T', '%{text}'), 'text': texts},
        style
        | quiet
        | {
            'x': finite_or_none(phase.frequency_hz),
            'y': finite_or_none(phase.phase_deg),
            'yaxis': 'y2',
        }
        | {'hovertemplate': hover('phase', '°')},
    ]
    if with_thd:
        traces.append(
            style
            | quiet
            | {
                'x': finite_or_none(curve.frequency_hz),
                'y': finite_or_none(100 * curve.thd),
                'yaxis': 'y3',
            }
            | {'hovertemplate': hover('THD', ' %')}
        )
    if item.events:
        traces.append(_event_trace(item, name, colour))
    return traces


def _markers(item: Shown, colour: str) -> Document:
    """Dots on the points, unless they are many, and arrows the way the sweep went."""
    n = len(item.curve.frequency_hz)
    symbols, sizes = ['circle'] * n, [4.5 if n <= MANY_POINTS else 0.0] * n
    arrow = ARROWS.get(item.curve.direction)
    if arrow:
        for k in arrow_indices(item.curve):
            symbols[k], sizes[k] = arrow.plotly, 11.0
    return {'symbol': symbols, 'size': sizes, 'color': colour, 'opacity': 1}


def _event_trace(item: Shown, name: str, colour: str) -> Document:
    events = item.events
    return {
        'type': 'scatter',
        'mode': 'markers',
        'name': f'{name}, events',
        'legendgroup': f'{item.item} {name}',
        'showlegend': False,
        'x': [number_or_none(event.frequency_hz) for event in events],
        'y': [number_or_none(event.magnitude) for event in events],
        'text': [escaped(event_name(event.kind)) for event in events],
        'customdata': [number_or_none(event.resolution_hz) for event in events],
        'marker': {
            'symbol': [event_mark(event.kind).plotly for event in events],
            'size': 12,
            'color': '#ffffff',
            'line': {'color': colour, 'width': 2.4},
        },
        'cliponaxis': False,
        'hovertemplate': '<b>%{text}</b><br>%{x:.3f} ± %{customdata:.3f} Hz<br>'
        f'T = %{{y:.4g}}<extra>{name}</extra>',
    }


def _layout(view: Ranges) -> Document:
    """Panels from the bottom up: THD (if any), phase, magnitude with half of the height or more."""
    with_thd = view.thd_percent is not None
    magnitude, phase, thd = (
        ([0.47, 1], [0.22, 0.43], [0, 0.18])
        if with_thd
        else (
            [0.36, 1],
            [0, 0.32],
            [0, 0],
        )
    )
    layout: Document = {
        'font': {'family': 'system-ui, sans-serif', 'size': 13, 'color': INK},
        'paper_bgcolor': '#ffffff',
        'plot_bgcolor': '#ffffff',
        'margin': {'l': 66, 'r': 14, 't': 34, 'b': 52},
        'hovermode': 'closest',
        'hoverlabel': {'bgcolor': '#ffffff', 'font': {'color': INK}},
        'legend': {'orientation': 'h', 'x': 0, 'y': -0.1, 'yanchor': 'top'},
        'xaxis': _frequency_axis(view, 'y3' if with_thd else 'y2'),
        'yaxis': _axis('|T|, top / base') | _log_axis(view.magnitude) | {'domain': magnitude},
        'yaxis2': _axis('phase, °')
        | {'domain': phase, 'range': list(view.phase_deg), 'dtick': 90, 'tick0': 0},
        'shapes': [_unit_line()],
        'annotations': [_unit_label()],
    }
    if with_thd:
        layout['yaxis3'] = _axis('THD, %') | {'domain': thd, 'range': [0, view.thd_percent]}
    return layout


def _axis(title: str) -> Document:
    return {
        'title': {'text': title, 'standoff': 8},
        'gridcolor': GRID,
        'linecolor': UNIT_LINE,
        'mirror': True,
        'showline': True,
        'zeroline': False,
        'ticks': 'outside',
        'tickcolor': UNIT_LINE,
        'nticks': 5,
    }


def _frequency_axis(view: Ranges, anchor: str) -> Document:
    low, high = view.frequency_hz
    margin = 0.02 * (high - low)
    own = (
        _log_axis((low / 1.03, high * 1.03))
        if view.log_frequency
        else {
            'range': [low - margin, high + margin],
            'nticks': 9,
        }
    )
    spikes = {
        'showspikes': True,
        'spikemode': 'across',
        'spikesnap': 'cursor',
        'spikethickness': 1,
        'spikedash': 'dot',
        'spikecolor': QUIET,
    }
    return _axis('frequency, Hz') | own | spikes | {'anchor': anchor, 'mirror': 'all'}


def _log_axis(span: tuple[float, float]) -> Document:
    """A logarithmic axis labelled 1, 2, 5; every digit below one decade, powers of ten above 3."""
    low, high = (math.log10(edge) for edge in span)
    decades = high - low
    named = (1, 2, 3, 4, 5, 6, 7, 8, 9) if decades < 0.9 else (1, 2, 5) if decades < 3 else (1,)
    values, texts = [], []
    for power in range(math.floor(low) - 2, math.ceil(high) + 2):
        for digit in range(1, 10):
            values.append(digit * 10.0**power)
            texts.append(f'{digit * 10.0**power:g}' if digit in named else '')
    return {
        'type': 'log',
        'range': [low, high],
        'tickmode': 'array',
        'tickvals': values,
        'ticktext': texts,
    }


def _unit_line() -> Document:
    line = {'color': UNIT_LINE, 'width': 1.5, 'dash': 'dot'}
    whole = {'x0': 0, 'x1': 1, 'xref': 'paper', 'y0': 1, 'y1': 1, 'yref': 'y'}
    return {'type': 'line', 'layer': 'below', 'line': line} | whole


def _unit_label() -> Document:
    place = {'x': 1, 'xref': 'paper', 'xanchor': 'right', 'y': 0, 'yref': 'y', 'yanchor': 'bottom'}
    text = {'text': 'T = 1', 'showarrow': False, 'font': {'size': 11, 'color': QUIET}}
    # On a logarithmic axis an annotation is placed by the exponent.
    return place | text
