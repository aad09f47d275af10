"""What jump frequencies fix, as text for people and as a document for programs."""

from __future__ import annotations

from typing import Any

import numpy as np

from qzs_rig.identification import told
from qzs_rig.identification.jumps import KNOWN, Fixed, determined
from qzs_rig.identification.unknowns import Unknown
from qzs_rig.report.names import dof_name, event_name
from qzs_rig.report.table import Table, number


def text(found: Fixed) -> str:
    """For the terminal."""
    items = zip(found.jumps, found.predicted_hz.tolist(), found.T.tolist(), strict=True)
    rows = tuple(
        (
            dof_name(jump.dof),
            event_name(jump.kind),
            f'{jump.frequency_hz:.2f}',
            f'{jump.std:.2f}',
            number(hz),
            number(T, '.2f'),
        )
        for jump, hz, T in items
    )
    header = ('degree of freedom', 'event', 'measured Hz', '±', 'model Hz', 'T before')
    values = zip(found.unknowns.items, found.values.tolist(), strict=True)
    spent = tuple((i.name, i.unit, f'{i.start:.5g}', f'{v:.5g}') for i, v in values)
    fixed = len(found.fixed)
    said = (
        f'{len(found.jumps)} frequencies for {len(found.values)} parameters: they fix {fixed} '
        f'combination{"s" * (fixed != 1)} to {KNOWN:.0%} and no parameter by itself'
    )
    if not determined(found):
        said += '.'
    else:
        said += f', but {", ".join(determined(found))}.'
    return '\n\n'.join(
        [
            Table('Jumps', header, rows).to_text(),
            Table(
                'A platform that jumps there, of least change: one of many',
                ('parameter', 'unit', 'start', 'value'),
                spent,
            ).to_text(),
            told.combinations(found.unknowns, found.directions).to_text(),
            said,
        ]
    )


def document(found: Fixed) -> dict[str, Any]:
    """JSON-ready."""
    predicted = [None if np.isnan(v) else v for v in found.predicted_hz.tolist()]
    return {
        'schema': told.SCHEMA,
        'jumps': [
            {**vars(jump), 'predicted_hz': hz}
            for jump, hz in zip(found.jumps, predicted, strict=True)
        ],
        'parameters': [
            _told(item, value, item.name in determined(found))
            for item, value in zip(found.unknowns.items, found.values.tolist(), strict=True)
        ],
        'combinations': told.combination_list(found.unknowns, found.directions),
        'fixed': len(found.fixed),
    }


def _told(item: Unknown, value: float, known: bool) -> dict[str, Any]:
    return {
        'name': item.name,
        'unit': item.unit,
        'start': item.start,
        'value': value,
        'determined': known,
    }
