"""An identification as tables for people and as a document for programs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from qzs_rig.identification.covariance import Direction
from qzs_rig.identification.identify import Identified
from qzs_rig.identification.intervals import LEVEL
from qzs_rig.identification.residuals import Set
from qzs_rig.identification.response import Response
from qzs_rig.identification.unknowns import TRIM, Unknowns
from qzs_rig.report.names import dof_name
from qzs_rig.report.table import Table

SCHEMA = 'qzs_rig/identification/1'


def text(found: Identified) -> str:
    """Everything for the terminal."""
    parts = [parameters(found).to_text(), points(found).to_text()]
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
    items = zip(found.fit.unknowns.items, found.fit.values, found.intervals, strict=True)
    for item, value, limit in items:
        known = f'{value:.6g}' if limit.determined else 'not determined'
        span = (f'{limit.low:.6g}', f'{limit.high:.6g}')
        rows.append((item.name, item.unit, known, f'{limit.std:.2g}', *span, limit.method))
    header = ('parameter', 'unit', 'estimate', '±', '95 % from', 'to', 'interval')
    return Table('Fitted parameters; the intervals hold together', header, tuple(rows))


def correlations(found: Identified) -> Table:
    """Of the estimates."""
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
    """A combination in letters, small parts left out; a trim is told over the payload."""
    terms = []
    for item, weight in zip(unknowns.items, direction.weights.tolist(), strict=True):
        if abs(weight) >= 0.02:
            below = 'm' if item.name == TRIM else _short(item.name)
            terms.append(f'{weight:+.2f} Δ{_short(item.name)}/{below}')
    return ' '.join(terms)


def points(found: Identified) -> Table:
    """How many points count, on which branch, how noisy."""
    rows = []
    for item, response in zip(found.fit.sets, found.fit.trial.state, strict=True):
        for direction in dict.fromkeys(item.points.direction.tolist()):
            here = item.points.direction == direction
            use = here & item.use
            upper = int(np.count_nonzero(use & response.upper))
            left = [f'{int(np.sum(here & (item.why == w)))} {w}' for w in _reasons(item, here)]
            noise = [f'{100 * value:.2g} %' for value in item.noise]
            rows.append(
                (
                    dof_name(item.points.dof),
                    direction,
                    str(int(np.count_nonzero(here))),
                    str(upper),
                    str(int(np.count_nonzero(use)) - upper),
                    ', '.join(left) or '–',
                    'given' if item.points.weighted else noise[0],
                )
            )
    header = ('degree of freedom', 'direction', 'points', 'upper', 'lower', 'left out', 'noise')
    return Table('Points on the upper and lower branch', header, tuple(rows))


def document(found: Identified) -> dict[str, Any]:
    """JSON-ready."""
    fit, advice = found.fit, found.advice
    items = zip(fit.unknowns.items, fit.values.tolist(), found.intervals, strict=True)
    return {
        'schema': SCHEMA,
        'parameters': [
            {'name': item.name, 'unit': item.unit, 'estimate': value, **vars(limit)}
            for item, value, limit in items
        ],
        'confidence': LEVEL,
        'jointly': True,
        'correlation': found.known.correlation.tolist(),
        'combinations': combination_list(fit.unknowns, found.known.directions),
        'reduced_chi_square': found.reduced_chi_square,
        'freedom': fit.freedom,
        'harmonics': found.harmonics,
        'points': [_points(*pair) for pair in zip(fit.sets, fit.trial.state, strict=True)],
        'other_solutions': [
            dict(zip(fit.unknowns.names, other.values.tolist(), strict=True))
            for other in found.others
        ],
        'advice': vars(advice) if advice else None,
        'cautions': list(found.cautions),
    }


def combination_list(unknowns: Unknowns, directions: Sequence[Direction]) -> list[dict[str, Any]]:
    """`combinations` for programs."""
    return [
        {
            'weights': dict(zip(unknowns.names, d.weights.tolist(), strict=True)),
            'relative_std': d.std,
        }
        for d in directions
    ]


def _points(item: Set, response: Response) -> dict[str, Any]:
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


def _reasons(item: Set, here: Any) -> list[str]:
    return sorted({str(why) for why in item.why[here].tolist() if why})


def _short(name: str) -> str:
    return name.removeprefix('platform.')


def _percent(share: float) -> str:
    return f'{100 * share:.2g} %' if share < 10 else 'free'
