"""Backbone, jump map and the motions over another parameter, beside a frequency response."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from qzs_rig.errors import InputError
from qzs_rig.report.response_page import Answer, branch_curves, path_document
from qzs_rig.report.sheet import Curve, Panel, Sheet, hue
from qzs_rig.report.table import Table
from qzs_rig.theory.balance.backbone import backbone, phase_resonance
from qzs_rig.theory.balance.harmonic_balance import value_of
from qzs_rig.theory.balance.variation import VariedResponse, jump_map
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import TRANSLATIONS


def with_backbone(answer: Answer, oscillator: Oscillator, low: float, high: float) -> Answer:
    """Conservative backbones, and the damped phase resonance of each."""
    free = backbone(oscillator, low, high)
    damped = [curve for b in free if (curve := phase_resonance(oscillator, b)) is not None]
    lines, rows = [], []
    for name, curves in (('backbone', free), ('phase resonance', damped)):
        for k, curve in enumerate(curves):
            colour = hue(2 * k % 4 + (name != 'backbone'))
            lines.append(Curve(f'{name} {k + 1}', curve.omega, curve.amplitude, colour))
            rows.append((f'{name} {k + 1}', *_ends(curve.omega), *_ends(curve.amplitude)))
    panel = Panel('motion in resonance', 'Ω', 'amplitude of w', tuple(lines), 'xy')
    sheet = Sheet(
        'backbone',
        'Backbone',
        'Undamped free motion (the extended periodic motion of one degree of freedom), and damped '
        'motion that lags its drive by 90 degrees.',
        (panel,),
    )
    head = ('curve', 'omega from', 'to', 'amplitude from', 'to')
    columns = ('omega', 'amplitude', 'damping_ratio', 'drive_hat')
    return replace(
        answer,
        document=answer.document
        | {
            name: [path_document(b, *columns) for b in curves]
            for name, curves in (('backbone', free), ('phase_resonance', damped))
        },
        tables=[*answer.tables, Table('resonance', head, tuple(rows), labels=1)],
        sheets=[*answer.sheets, sheet],
    )


def with_jump_map(
    answer: Answer,
    oscillator: Oscillator,
    parameter: str,
    omega: tuple[float, float],
    progress: Callable[[float, str], None],
) -> Answer:
    """Folds while `parameter` goes from a tenth to three times its value."""
    value = value_of(oscillator, 1.0, parameter)
    if not value > 0.0:
        raise InputError(f'--jump-map {parameter}: it is {value:g}; give a value above 0')
    curves = jump_map(oscillator, parameter, (value / 10, value * 3), *omega, progress=progress)
    lines = tuple(Curve(f'folds {k + 1}', c.value, c.omega, hue(k)) for k, c in enumerate(curves))
    panel = Panel('where motions jump', parameter, 'Ω of the fold', lines, 'xy')
    sheet = Sheet('jump_map', 'Jump map', 'Folds of the frequency response.', (panel,))
    rows = tuple(
        (f'folds {k + 1}', *_ends(np.sort(c.value)), *_ends(np.sort(c.omega)))
        for k, c in enumerate(curves)
    )
    head = ('curve', f'{parameter} from', 'to', 'omega from', 'to')
    found = {
        'parameter': parameter,
        'curves': [path_document(c, 'value', 'omega', 'T', 'amplitude') for c in curves],
    }
    return replace(
        answer,
        document=answer.document | {'jump_map': found},
        tables=[*answer.tables, Table('jump map', head, rows, labels=1)],
        sheets=[*answer.sheets, sheet] if curves else answer.sheets,
    )


def with_variation(answer: Answer, found: VariedResponse) -> Answer:
    """Motions at one frequency over another parameter."""
    name, unit = found.parameter, 'w / L20' if found.oscillator.dof in TRANSLATIONS else 'w, rad'
    sheet = Sheet(
        'variation',
        f'Motions at Ω = {found.omega:g} over {name}',
        'Fundamentals. Unstable motions are dashed.',
        (
            Panel('(a) transmissibility', name, '|u / v|', _varied(found, 'T'), 'xy', 1.0),
            Panel('(b) relative motion', name, unit, _varied(found, 'amplitude'), 'xy'),
        ),
    )
    rows = tuple(
        (
            f'{k + 1}',
            f'{len(b.value)}',
            *_ends(b.value),
            f'{100 * float(np.mean(b.stable)):.0f} %',
            ', '.join(f'{value:.8g}' for value in _folds(found, k)) or 'none',
        )
        for k, b in enumerate(found.branches)
    )
    head = ('branch', 'points', f'{name} from', 'to', 'stable', 'folds')
    document = {
        'parameter': name,
        'omega': found.omega,
        'branches': [
            path_document(b, 'value', 'T', 'amplitude', 'phase_deg', 'stable')
            | {'folds': _folds(found, k)}
            for k, b in enumerate(found.branches)
        ],
    }
    return replace(
        answer,
        document=answer.document | {'variation': document},
        tables=[*answer.tables, Table(f'at omega {found.omega:g}', head, rows, labels=1)],
        sheets=[*answer.sheets, sheet] if found.branches else answer.sheets,
    )


def _folds(found: VariedResponse, number: int) -> list[float]:
    return [e.value for e in found.events if (e.kind, e.branch) == ('fold', number)]


def _varied(found: VariedResponse, what: str) -> tuple[Curve, ...]:
    return tuple(
        curve
        for k, branch in enumerate(found.branches)
        for curve in branch_curves([branch], what, f'motions {k + 1}', hue(k), over='value')
    )


def _ends(values: np.ndarray[tuple[int], np.dtype[np.float64]]) -> tuple[str, str]:
    return f'{values[0]:.6g}', f'{values[-1]:.6g}'
