"""Predictions as JSON: the topic `theory/branches` and the file `theory.json`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from qzs_rig.errors import InputError
from qzs_rig.files import finite_or_none
from qzs_rig.prediction.curve import Branch, Fold, Prediction
from qzs_rig.units import displacement_unit

SCHEMA = 'qzs_rig/theory/1'
_COLUMNS = ('frequency_hz', 'transmissibility', 'phase_deg', 'stroke')


def to_document(run_id: str, predictions: Sequence[Prediction]) -> dict[str, Any]:
    """JSON-ready; floats survive the round trip bit by bit, NaN becomes null."""
    return {
        'schema': SCHEMA,
        'run_id': run_id,
        'predictions': [
            {
                'dof': prediction.dof,
                'label': prediction.label,
                'method': prediction.method,
                'stroke_unit': displacement_unit(prediction.dof),
                'onset_hz': list(prediction.onset_hz),
                'branches': [_branch_document(branch) for branch in prediction.branches],
                'folds': [_fold_document(fold) for fold in prediction.folds],
            }
            for prediction in predictions
        ],
    }


def from_document(document: Any) -> tuple[Prediction, ...]:
    """The predictions in a parsed JSON document; raises InputError naming what is wrong."""
    if not isinstance(document, dict) or document.get('schema') != SCHEMA:
        found = document.get('schema') if isinstance(document, dict) else type(document).__name__
        raise InputError(f'not a theory: schema is {found!r}, expected {SCHEMA!r}')
    try:
        return tuple(
            Prediction(
                str(item['dof']),
                str(item['label']),
                str(item['method']),
                tuple(_branch(branch) for branch in item['branches']),
                tuple(_fold(fold) for fold in item['folds']),
                tuple(float(hz) for hz in item['onset_hz']),
            )
            for item in document['predictions']
        )
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f'damaged theory: {error!r}; predict it again') from error


def _branch_document(branch: Branch) -> dict[str, Any]:
    columns = {name: finite_or_none(getattr(branch, name)) for name in _COLUMNS}
    return {'name': branch.name, **columns, 'stable': branch.stable.tolist()}


def _branch(item: dict[str, Any]) -> Branch:
    hz, T, phase, stroke = (np.array(item[name], dtype=np.float64) for name in _COLUMNS)
    return Branch(str(item['name']), hz, T, phase, stroke, np.array(item['stable'], dtype=bool))


def _fold_document(fold: Fold) -> dict[str, Any]:
    pairs = {name: finite_or_none(getattr(fold, name)) for name in ('transmissibility', 'stroke')}
    names = {'kind': fold.kind, 'leaves': fold.leaves, 'lands': fold.lands}
    return {'frequency_hz': fold.frequency_hz, **names, **pairs}


def _fold(item: dict[str, Any]) -> Fold:
    kind, leaves, lands = (str(item[name]) for name in ('kind', 'leaves', 'lands'))
    pairs = (_pair(item[name]) for name in ('transmissibility', 'stroke'))
    return Fold(float(item['frequency_hz']), kind, leaves, lands, *pairs)


def _pair(values: Sequence[float | None]) -> tuple[float, float]:
    before, after = (math.nan if value is None else float(value) for value in values)
    return before, after
