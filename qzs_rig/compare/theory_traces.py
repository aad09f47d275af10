"""Theory in the interactive figure: its branches, its folds, and where the points lie on it."""

from __future__ import annotations

import math
from collections.abc import Sequence

from qzs_rig.compare.look import FOLD_MARKS
from qzs_rig.compare.panels import theory_line
from qzs_rig.compare.traces import Document, escaped, hover
from qzs_rig.estimation.estimate import Curve
from qzs_rig.files import finite_or_none, number_or_none
from qzs_rig.prediction.curve import Fold, Prediction
from qzs_rig.prediction.labels import NONE, label
from qzs_rig.report.names import event_name


def theory_traces(theory: Prediction, colour: str) -> list[Document]:
    """Stable branches solid, others dashed, in magnitude and phase; an arrow at each fold."""
    traces: list[Document] = []
    for stable in (True, False):
        line = theory_line(theory, stable)
        if not line.frequency_hz.size:
            continue
        name = escaped(theory.label) + ('' if stable else ', unstable')
        style = {
            'type': 'scatter',
            'mode': 'lines',
            'x': finite_or_none(line.frequency_hz),
            'name': name,
            'legendgroup': name,
            'line': {'color': colour, 'width': 1.1, 'dash': 'solid' if stable else '5px,4px'},
        }
        traces.append(
            style | {'y': finite_or_none(line.magnitude), 'hovertemplate': hover('T', '')}
        )
        traces.append(
            style
            | {'y': finite_or_none(line.phase_deg), 'yaxis': 'y2', 'showlegend': False}
            | {'hovertemplate': hover('phase', '°')}
        )
    return [*traces, _fold_trace(theory, colour)] if theory.folds else traces


def _fold_trace(theory: Prediction, colour: str) -> Document:
    return {
        'type': 'scatter',
        'mode': 'markers',
        'name': escaped(f'{theory.label}, folds'),
        'x': [number_or_none(fold.frequency_hz) for fold in theory.folds],
        'y': [number_or_none(fold.transmissibility[0]) for fold in theory.folds],
        'text': [escaped(_fold_text(fold)) for fold in theory.folds],
        'marker': {
            'symbol': [FOLD_MARKS[fold.kind].plotly for fold in theory.folds],
            'size': 11,
            'color': colour,
        },
        'hovertemplate': '%{text}<extra>%{fullData.name}</extra>',
    }


def _fold_text(fold: Fold) -> str:
    T, after = fold.transmissibility
    lands = f'to T = {after:.4g} on the {fold.lands} branch' if fold.lands else 'to where?'
    return f'{event_name(fold.kind)} at {fold.frequency_hz:.4f} Hz from T = {T:.4g} {lands}'


def point_texts(curve: Curve, predictions: Sequence[Prediction]) -> list[str]:
    """Branch and distance of each point of `curve`, for its hover; empty without one theory."""
    if len(predictions) != 1:
        return [''] * len(curve.frequency_hz)
    found = label(curve, predictions[0])
    return [
        f'<br>{escaped(name)} branch' + (f', z = {z:+.2f}' if math.isfinite(z) else '')
        if name != NONE
        else '<br>on no branch'
        for name, z in zip(found.branch, found.z.tolist(), strict=True)
    ]
