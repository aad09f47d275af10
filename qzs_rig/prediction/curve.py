"""The predicted response of one degree of freedom, in hertz, metres or radians, and degrees.

As JSON it is the topic `theory/branches` and the file `theory.json`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cmp_to_key
from typing import Any

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import InputError
from qzs_rig.files import finite_or_none
from qzs_rig.samples import Array
from qzs_rig.units import displacement_unit

SCHEMA = 'qzs_rig/theory/1'
_COLUMNS = ('frequency_hz', 'transmissibility', 'phase_deg', 'stroke')
EDGE = 1e-9
"""A branch that ends this close (relative) to the end of the range ends there, and in no fold."""


@dataclass(frozen=True)
class Branch:
    """Steady states (n,) by rising frequency, from one fold or end of the range to the next.

    `transmissibility` is |top| / |base| of the fundamentals, `phase_deg` that of the top against
    the base in (-180, 180], `stroke` the largest distance of top and base in a period from where
    they rest, m or rad. `stable`: a platform can stay there.
    """

    name: str
    frequency_hz: Array
    transmissibility: Array
    phase_deg: Array
    stroke: Array
    stable: NDArray[np.bool_]

    def at(self, frequency_hz: Array, values: Array) -> Array:
        """`values` (n,) of the branch at `frequency_hz` (m,), NaN where it is not stable."""
        f = self.frequency_hz
        right = np.clip(np.searchsorted(f, frequency_hz), 1, len(f) - 1)
        steady = self.stable[right - 1] & self.stable[right]
        inside = (frequency_hz >= f[0]) & (frequency_hz <= f[-1]) & steady
        return np.where(inside, np.interp(frequency_hz, f, values), np.nan)


@dataclass(frozen=True)
class Fold:
    """Where a sweep along the stable branch `leaves` cannot go on and jumps at constant frequency
    to the nearest stable branch `lands`, or '' where the prediction knows none.

    `kind` is jump_up or jump_down, by the stroke. `transmissibility` and `stroke` are (before,
    after); after is NaN where nothing is known.
    """

    frequency_hz: float
    kind: str
    leaves: str
    lands: str
    transmissibility: tuple[float, float]
    stroke: tuple[float, float]


@dataclass(frozen=True)
class Prediction:
    """What theory says of one degree of freedom of a run. `method` is `harmonic_balance` or
    `single_term`; `onset_hz` are the frequencies where T crosses 1, ascending."""

    dof: str
    label: str
    method: str
    branches: tuple[Branch, ...]
    folds: tuple[Fold, ...]
    onset_hz: tuple[float, ...]


def named(branches: Iterable[Branch]) -> tuple[Branch, ...]:
    """Stable ones `lower`, `upper`, `upper 2`... by their stroke, others `middle`...; `only` where
    there is one."""
    parts = sorted(branches, key=cmp_to_key(_by_stroke))
    if len(parts) == 1:
        return (replace(parts[0], name='only'),)
    steady = [part for part in parts if part.stable.any()]
    others = [part for part in parts if not part.stable.any()]
    names = ['lower', *_numbered('upper', len(steady) - 1)]
    return (
        *(replace(part, name=name) for part, name in zip(steady, names, strict=False)),
        *(
            replace(part, name=name)
            for part, name in zip(others, _numbered('middle', len(others)), strict=True)
        ),
    )


def _by_stroke(one: Branch, other: Branch) -> int:
    """Negative where `one` moves less, amid the frequencies that both have."""
    low = max(one.frequency_hz[0], other.frequency_hz[0])
    high = min(one.frequency_hz[-1], other.frequency_hz[-1])
    strokes = [
        float(np.interp(0.5 * (low + high), part.frequency_hz, part.stroke))
        if low < high
        else float(np.mean(part.stroke))
        for part in (one, other)
    ]
    return int(np.sign(strokes[0] - strokes[1]))


def _numbered(word: str, count: int) -> list[str]:
    return [word if k == 0 else f'{word} {k + 1}' for k in range(count)]


def folds(branches: Sequence[Branch], low_hz: float, high_hz: float) -> tuple[Fold, ...]:
    """The ends of the stable branches within the range, by frequency."""
    found = []
    for branch in branches:
        for end, inside in ((0, branch.frequency_hz[0] > low_hz * (1 + EDGE)),
                            (-1, branch.frequency_hz[-1] < high_hz * (1 - EDGE))):  # fmt: skip
            if inside and branch.stable[end]:
                found.append(_fold(branch, end, branches))
    return tuple(sorted(found, key=lambda fold: fold.frequency_hz))


def _fold(branch: Branch, end: int, branches: Sequence[Branch]) -> Fold:
    hz, T, stroke = (
        float(column[end])
        for column in (branch.frequency_hz, branch.transmissibility, branch.stroke)
    )
    after = landing(hz, stroke, [other for other in branches if other is not branch])
    there = np.array([hz])
    T_after, stroke_after = (
        (float(after.at(there, values)[0]) for values in (after.transmissibility, after.stroke))
        if after
        else (float('nan'), float('nan'))
    )
    kind = 'jump_down' if stroke_after < stroke else 'jump_up'
    lands = after.name if after else ''
    return Fold(hz, kind, branch.name, lands, (T, T_after), (stroke, stroke_after))


def landing(frequency_hz: float, stroke: float, branches: Sequence[Branch]) -> Branch | None:
    """The stable one of `branches` nearest in stroke at a frequency, None where there is none."""
    there = np.array([frequency_hz])
    gaps = [abs(float(branch.at(there, branch.stroke)[0]) - stroke) for branch in branches]
    known = [(gap, k) for k, gap in enumerate(gaps) if np.isfinite(gap)]
    return branches[min(known)[1]] if known else None


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
                tuple(_branch_from(branch) for branch in item['branches']),
                tuple(_fold_from(fold) for fold in item['folds']),
                tuple(float(hz) for hz in item['onset_hz']),
            )
            for item in document['predictions']
        )
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f'damaged theory: {error!r}; predict it again') from error


def _branch_document(branch: Branch) -> dict[str, Any]:
    columns = {name: finite_or_none(getattr(branch, name)) for name in _COLUMNS}
    return {'name': branch.name, **columns, 'stable': branch.stable.tolist()}


def _branch_from(item: dict[str, Any]) -> Branch:
    hz, T, phase, stroke = (np.array(item[name], dtype=np.float64) for name in _COLUMNS)
    return Branch(str(item['name']), hz, T, phase, stroke, np.array(item['stable'], dtype=bool))


def _fold_document(fold: Fold) -> dict[str, Any]:
    pairs = {name: finite_or_none(getattr(fold, name)) for name in ('transmissibility', 'stroke')}
    return asdict(fold) | pairs


def _fold_from(item: dict[str, Any]) -> Fold:
    kind, leaves, lands = (str(item[name]) for name in ('kind', 'leaves', 'lands'))
    # numpy takes null for NaN
    (T, T_after), (stroke, stroke_after) = (
        np.array(item[name], dtype=np.float64).tolist() for name in ('transmissibility', 'stroke')
    )
    hz = float(item['frequency_hz'])
    return Fold(hz, kind, leaves, lands, (T, T_after), (stroke, stroke_after))
