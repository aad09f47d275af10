"""An identification as tables for people and as a document for programs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from qzs_rig.files import finite_or_none
from qzs_rig.identification.fit import DataSet
from qzs_rig.identification.identify import Identified
from qzs_rig.identification.intervals import LEVEL, Direction
from qzs_rig.identification.jumps import KNOWN, Fixed
from qzs_rig.identification.point_response import Response
from qzs_rig.identification.unknowns import TRIM, Unknowns
from qzs_rig.report.names import direction_name, dof_name, event_name
from qzs_rig.report.response_page import branch_curves
from qzs_rig.report.sheet import QUIET, Item, Panel, Points, Sheet
from qzs_rig.report.table import Table, number
from qzs_rig.report.transmissibility import ARROWS, FREQUENCY, MAGNITUDE, PHASE, hue
from qzs_rig.samples import Array
from qzs_rig.theory.balance.frequency_response import frequency_response
from qzs_rig.theory.oscillator import Oscillator

MARGIN = 1.05
"""Branches are drawn a little beyond the measured band."""
SCHEMA = 'qzs_rig/identification/1'


def fit_text(found: Identified) -> str:
    """Tables of parameters, correlations and points, and what to do about the payload, as text."""
    parts = [parameters(found).to_text(), point_table(found).to_text()]
    if len(found.intervals) > 1:
        parts.insert(1, correlations(found).to_text())
    if not all(limit.determined for limit in found.intervals):
        parts.insert(1, combinations(found.fit.unknowns, found.known.directions).to_text())
    if found.advice is not None:
        parts.append(f'payload: {found.advice.text}')
    return '\n\n'.join(parts)


def parameters(found: Identified) -> Table:
    """Estimates with their intervals."""
    rows = []
    fitted = found.fit.unknowns
    items = zip(fitted.names, fitted.units, found.fit.values, found.intervals, strict=True)
    for name, unit, value, limit in items:
        known = f'{value:.6g}' if limit.determined else 'not determined'
        span = (f'{limit.low:.6g}', f'{limit.high:.6g}')
        rows.append((name, unit, known, f'{limit.std:.2g}', *span, limit.method))
    header = ('parameter', 'unit', 'estimate', '±', '95 % from', 'to', 'interval')
    return Table('Fitted parameters; the intervals hold together', header, tuple(rows))


def correlations(found: Identified) -> Table:
    """Correlations of the estimates with each other."""
    names = [_short(name) for name in found.fit.unknowns.names]
    rows = tuple(
        (name, *(f'{value:+.3f}' for value in row))
        for name, row in zip(names, found.known.correlation.tolist(), strict=True)
    )
    return Table('Correlation of the estimates', ('', *names), rows, labels=1)


def combinations(unknowns: Unknowns, directions: Sequence[Direction]) -> Table:
    """What the data fix, best known first."""
    rows = tuple((formula(unknowns, d), _percent(d.std)) for d in directions)
    caption = 'Combinations of relative changes, and to what each is known'
    return Table(caption, ('combination', '±'), rows, labels=1)


def formula(unknowns: Unknowns, direction: Direction) -> str:
    """A combination in letters, small parts left out; a trim is shown over the payload."""
    terms = []
    for name, weight in zip(unknowns.names, direction.weights.tolist(), strict=True):
        if abs(weight) >= 0.02:
            below = 'm' if name == TRIM else _short(name)
            terms.append(f'{weight:+.2f} Δ{_short(name)}/{below}')
    return ' '.join(terms)


def point_table(found: Identified) -> Table:
    """How many points count, on which branch, how noisy."""
    rows = []
    for item, response in zip(found.fit.sets, found.fit.responses, strict=True):
        for direction in dict.fromkeys(item.points.direction.tolist()):
            here = item.points.direction == direction
            use = here & item.use
            upper = int(np.count_nonzero(use & response.upper))
            why, counts = np.unique(item.why[here & ~item.use], return_counts=True)
            left = [f'{count} {word}' for count, word in zip(counts, why, strict=True)]
            rows.append(
                (
                    dof_name(item.points.dof),
                    direction,
                    str(int(np.count_nonzero(here))),
                    str(upper),
                    str(int(np.count_nonzero(use)) - upper),
                    ', '.join(left) or '–',
                    'given' if item.points.weighted else f'{100 * item.noise[0]:.2g} %',
                )
            )
    header = ('degree of freedom', 'direction', 'points', 'upper', 'lower', 'left out', 'noise')
    return Table('Points on the upper and lower branch', header, tuple(rows))


def fit_document(found: Identified) -> dict[str, Any]:
    """The whole result, ready for JSON."""
    fit, advice = found.fit, found.advice
    names, units = fit.unknowns.names, fit.unknowns.units
    items = zip(names, units, fit.values.tolist(), found.intervals, strict=True)
    return {
        'schema': SCHEMA,
        'parameters': [
            {'name': name, 'unit': unit, 'estimate': value, **vars(limit)}
            for name, unit, value, limit in items
        ],
        'confidence': LEVEL,
        'jointly': True,
        'correlation': found.known.correlation.tolist(),
        'combinations': combination_list(fit.unknowns, found.known.directions),
        'reduced_chi_square': found.reduced_chi_square,
        'freedom': fit.freedom,
        'harmonics': found.harmonics,
        'points': [_points(*pair) for pair in zip(fit.sets, fit.responses, strict=True)],
        'other_solutions': [
            dict(zip(fit.unknowns.names, other.values.tolist(), strict=True))
            for other in found.others
        ],
        'advice': vars(advice) if advice else None,
        'cautions': list(found.cautions),
    }


def combination_list(unknowns: Unknowns, directions: Sequence[Direction]) -> list[dict[str, Any]]:
    """The rows of `combinations`, ready for JSON: weights by parameter, relative_std."""
    return [
        {
            'weights': dict(zip(unknowns.names, d.weights.tolist(), strict=True)),
            'relative_std': d.std,
        }
        for d in directions
    ]


def _points(item: DataSet, response: Response) -> dict[str, Any]:
    measured, shown = item.points, response.ratio * item.lag
    return {
        'dof': measured.dof,
        'direction': measured.direction.tolist(),
        'frequency_hz': measured.frequency_hz.tolist(),
        'T': measured.magnitude.tolist(),
        'fitted_T': [
            float(v) if g else None for v, g in zip(abs(shown), response.good, strict=True)
        ],
        'branch': ['upper' if up else 'lower' for up in response.upper],
        'left_out': item.why.tolist(),
        'noise': None if measured.weighted else list(item.noise),
    }


def jumps_text(found: Fixed) -> str:
    """Tables of the jumps, of a platform that jumps there and of what is fixed, as text."""
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
    own = found.unknowns
    values = zip(own.names, own.units, own.start, found.values, strict=True)
    spent = tuple((name, unit, f'{start:.5g}', f'{v:.5g}') for name, unit, start, v in values)
    fixed = len(found.fixed)
    but = ', '.join(found.determined)
    said = (
        f'{len(found.jumps)} frequencies for {len(found.values)} parameters: they fix {fixed} '
        f'combination{"s" * (fixed != 1)} to {KNOWN:.0%} and no parameter by itself'
        f'{but and f", but {but}"}.'
    )
    return '\n\n'.join(
        [
            Table('Jumps', header, rows).to_text(),
            Table(
                'A platform near by that jumps there: one of many',
                ('parameter', 'unit', 'start', 'value'),
                spent,
            ).to_text(),
            combinations(found.unknowns, found.directions).to_text(),
            said,
        ]
    )


def jumps_document(found: Fixed) -> dict[str, Any]:
    """The whole result, ready for JSON."""
    predicted = finite_or_none(found.predicted_hz)
    own = found.unknowns
    values = zip(own.names, own.units, own.start.tolist(), found.values.tolist(), strict=True)
    return {
        'schema': SCHEMA,
        'jumps': [
            {**vars(jump), 'predicted_hz': hz}
            for jump, hz in zip(found.jumps, predicted, strict=True)
        ],
        'parameters': [
            {
                'name': name,
                'unit': unit,
                'start': start,
                'value': value,
                'determined': name in found.determined,
            }
            for name, unit, start, value in values
        ],
        'combinations': combination_list(found.unknowns, found.directions),
        'fixed': len(found.fixed),
    }


def fit_sheet(found: Identified) -> Sheet:
    """A column a degree of freedom: the branches settled, the points with the lag of their sweep
    taken off."""
    columns = []
    at = 0
    for item in found.fit.sets:
        n = 2 * len(item.points)
        residual = found.fit.all_residuals[at : at + n].reshape(2, -1)
        columns.append(_column(found, item, residual))
        at += n
    panels = tuple(panel for row in zip(*columns, strict=True) for panel in row)
    return Sheet('fit', 'Fitted platform', '', panels, columns=len(columns), linked=True)


def _column(found: Identified, item: DataSet, residual: Array) -> tuple[Panel, Panel, Panel]:
    points = item.points
    there = Oscillator.driven(found.spec, points.dof)
    omega = there.omega(points.frequency_hz)
    band = float(omega.min()) / MARGIN, float(omega.max()) * MARGIN
    branches = frequency_response(there, *band, isolas=False).branches
    settled = points.magnitude / np.abs(item.lag)
    turned = np.degrees(np.angle(np.exp(1j * points.phase) / item.lag))
    magnitude: list[Item] = [*branch_curves(branches, 'T', 'fit', QUIET, there.hertz, 1.0)]
    phase: list[Item] = [*branch_curves(branches, 'phase_deg', 'fit', QUIET, there.hertz, 1.0)]
    misses: list[Item] = []
    for direction in dict.fromkeys(points.direction.tolist()):
        here = points.direction == direction
        use, out = here & item.use, here & ~item.use
        words, phased = direction_name(direction), use & points.phased
        for items, label, y, where, hollow in (
            (magnitude, words, settled, use, False),
            (magnitude, f'{words}, left out', settled, out, True),
            (phase, words, turned, use, False),
            (misses, words, residual[0], use, False),
            (misses, f'{words}, phase', residual[1], phased, True),
        ):
            if where.any():
                mark = ARROWS.get(direction, 'dot')
                f, colour = points.frequency_hz[where], hue(0, direction)
                items.append(Points(label, f, y[where], colour, mark, 4.0, hollow))
    title = f'{dof_name(points.dof)}: fitted branches'
    about = 'residual / std\n(open: phase)'
    return (
        Panel(title, FREQUENCY, MAGNITUDE, tuple(magnitude), 'y', 1.0, height=0.6),
        Panel('', FREQUENCY, PHASE, tuple(phase), height=0.3),
        Panel('', FREQUENCY, about, tuple(misses), level=0.0, height=0.3),
    )


def _short(name: str) -> str:
    return name.removeprefix('platform.')


def _percent(share: float) -> str:
    return f'{100 * share:.2g} %' if share < 10 else 'free'
