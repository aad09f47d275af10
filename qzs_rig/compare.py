"""Runs against each other and against theory: curves, events, measured points."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import product, zip_longest
from typing import Any

import numpy as np

from qzs_rig.errors import InputError
from qzs_rig.estimation.estimate import Curve, Estimate, Event
from qzs_rig.files import finite_or_none, number_or_none
from qzs_rig.prediction.curve import Prediction
from qzs_rig.prediction.labels import NEAR, label
from qzs_rig.report.names import dof_name, dof_order, event_name
from qzs_rig.report.table import MISSING, Table, number
from qzs_rig.samples import Array

SCHEMA = 'qzs_rig/compare/1'

Labelled = tuple[str, Estimate]
Direction = str | None
"""None: the run has nothing there."""


@dataclass(frozen=True)
class CurveDifference:
    """Curve `b` against curve `a` over the frequencies both cover, in percent of a's T.

    `note` says why there are no numbers (a counterpart is missing, the ranges do not overlap), or
    that the two curves are different quantities. `max_at_hz` is where |ΔT|/T is largest.
    """

    dof: str
    direction: str
    a: str
    b: str
    rms_percent: float | None = None
    max_percent: float | None = None
    max_at_hz: float | None = None
    max_phase_deg: float | None = None
    frequency_hz: tuple[float, float] | None = None
    points: int = 0
    note: str = ''


@dataclass(frozen=True)
class EventDifference:
    """One event as seen by `a` and by `b`; None where one of them has no such event.

    `difference_hz` is b - a; `resolution_hz` the coarser spacing of the two, so that a difference
    below it means nothing.
    """

    dof: str
    direction: str
    kind: str
    a: str
    b: str
    a_hz: float | None
    b_hz: float | None
    difference_hz: float | None
    a_magnitude: float | None
    b_magnitude: float | None
    magnitude_percent: float | None
    resolution_hz: float
    note: str = ''


@dataclass(frozen=True)
class TheoryDifference:
    """Measured points against the nearest stable branch of `theory`, in percent of its T.

    The arrays hold every measured point, in the curve's order: its `branch` (`none` where no
    stable one is near, counted by `unmatched`), the branch's T, the deviation from it in percent
    and in standard uncertainties (`z`), NaN where there is no branch. `near` counts |z| <= 2.
    """

    dof: str
    direction: str
    item: str
    theory: str
    rms_percent: float | None
    max_percent: float | None
    max_at_hz: float | None
    max_phase_deg: float | None
    points: int
    unmatched: int
    near: int
    branches: str
    frequency_hz: Array
    magnitude: Array
    theory_magnitude: Array
    deviation_percent: Array
    branch: tuple[str, ...]
    z: Array


Columns = dict[str, Callable[[Any], str]]
"""A column's header, and the text of a row's cell."""

CURVE = 'Transmissibility of b against a, over their common range'
EVENT = 'Events of b against a'
THEORY = 'Measured transmissibility against the nearest stable branch of the theory'
WHERE: Columns = {
    'degree of freedom': lambda row: dof_name(row.dof),
    'direction': lambda row: row.direction,
}
PAIR: Columns = {'a': lambda row: row.a, 'b': lambda row: row.b}
LARGEST: Columns = {
    'rms %': lambda row: number(row.rms_percent, '.2f'),
    'max %': lambda row: number(row.max_percent, '.2f'),
    'at Hz': lambda row: number(row.max_at_hz),
    'phase °': lambda row: number(row.max_phase_deg, '.1f'),
}
CURVE_COLUMNS: Columns = {
    **WHERE,
    **PAIR,
    **LARGEST,
    'from Hz': lambda row: number(row.frequency_hz and row.frequency_hz[0]),
    'to Hz': lambda row: number(row.frequency_hz and row.frequency_hz[1]),
    'remark': lambda row: row.note,
}
EVENT_COLUMNS: Columns = {
    **WHERE,
    'event': lambda row: event_name(row.kind),
    **PAIR,
    'a Hz': lambda row: number(row.a_hz),
    'b Hz': lambda row: number(row.b_hz),
    'b - a Hz': lambda row: number(row.difference_hz, '+.3f'),
    '± Hz': lambda row: number(row.resolution_hz),
    'a T': lambda row: number(row.a_magnitude),
    'b T': lambda row: number(row.b_magnitude),
    'ΔT %': lambda row: number(row.magnitude_percent, '+.2f'),
    'remark': lambda row: row.note,
}
THEORY_COLUMNS: Columns = {
    **WHERE,
    'run': lambda row: row.item,
    'theory': lambda row: row.theory,
    **LARGEST,
    'points': lambda row: str(row.points),
    'unmatched': lambda row: str(row.unmatched),
    f'within {NEAR:g}σ': lambda row: str(row.near) if np.isfinite(row.z).any() else MISSING,
    'remark': lambda row: row.branches,
}


@dataclass(frozen=True)
class Comparison:
    """The first of `items` against every other, and all of them against theory."""

    items: tuple[str, ...]
    curves: tuple[CurveDifference, ...]
    events: tuple[EventDifference, ...]
    theory: tuple[TheoryDifference, ...]

    def to_document(self) -> dict[str, Any]:
        """A JSON-ready document (`qzs_rig/compare/1`); NaN becomes null."""
        document = {'schema': SCHEMA, **asdict(self)}
        for row in (*document['curves'], *document['events'], *document['theory']):
            for name, value in row.items():
                if isinstance(value, np.ndarray):
                    row[name] = finite_or_none(value)
                elif isinstance(value, float):
                    row[name] = number_or_none(value)
        return document

    def tables(self) -> tuple[Table, ...]:
        """Events, curves and theory for the eye; empty ones left out."""
        tables = (
            _table(EVENT, 5, EVENT_COLUMNS, self.events),
            _table(CURVE, 4, CURVE_COLUMNS, self.curves),
            _table(THEORY, 4, THEORY_COLUMNS, self.theory),
        )
        return tuple(table for table in tables if table.rows)

    def to_text(self) -> str:
        """`tables` for the terminal."""
        return '\n\n'.join(table.to_text() for table in self.tables())


def compare(estimates: Sequence[Labelled], theory: Sequence[Prediction] = ()) -> Comparison:
    """Compare labelled `estimates`: the first is the reference of all others.

    Curves pair by degree of freedom, direction and order; direction `none` pairs with any
    direction the other lacks. Raises InputError for labels that are not distinct.
    """
    labels = tuple(name for name, _ in estimates)
    if len(set(labels)) < len(labels):
        raise InputError(f'two items share a label: {", ".join(labels)}; name them apart')
    curves: list[CurveDifference] = []
    events: list[EventDifference] = []
    for other in estimates[1:]:
        curves.extend(_curve_differences(estimates[0], other))
        events.extend(_event_differences(estimates[0], other))
    against = (
        theory_difference(name, curve, prediction)
        for name, estimate in estimates
        for curve in estimate.curves
        for prediction in theory
        if prediction.dof == curve.dof
    )
    return Comparison(labels, tuple(curves), tuple(events), tuple(against))


def curve_difference(a_label: str, a: Curve, b_label: str, b: Curve) -> CurveDifference:
    """`b` against `a`, on the points of both within the common range: log T and unwrapped phase
    are interpolated linearly in frequency, unusable (NaN) points left out."""
    head = (a.dof, _joint(a.direction, b.direction), a_label, b_label)
    fa, Ta, pa = _ascending(a)
    fb, Tb, pb = _ascending(b)
    if not fa.size or not fb.size:
        return CurveDifference(*head, note='no usable points')
    low, high = max(fa[0], fb[0]), min(fa[-1], fb[-1])
    if low > high:
        note = f'no common range: {fa[0]:g}-{fa[-1]:g} Hz and {fb[0]:g}-{fb[-1]:g} Hz'
        return CurveDifference(*head, note=note)
    grid = np.union1d(fa, fb)
    grid = grid[(grid >= low) & (grid <= high)]
    ratio = np.exp(np.interp(grid, fb, np.log(Tb)) - np.interp(grid, fa, np.log(Ta)))
    same = (a.quantity, a.estimator) == (b.quantity, b.estimator)
    return CurveDifference(
        *head,
        *_largest(grid, ratio, np.interp(grid, fb, pb) - np.interp(grid, fa, pa)),
        frequency_hz=(float(low), float(high)),
        points=len(grid),
        note='' if same else f'{a.estimator} {a.quantity} against {b.estimator} {b.quantity}',
    )


def theory_difference(item: str, curve: Curve, theory: Prediction) -> TheoryDifference:
    """Every measured point of `curve` against the stable branch of `theory` nearest in log T."""
    f, T = curve.frequency_hz, curve.magnitude
    labels = label(curve, theory)
    ratio = T / labels.transmissibility
    used = np.isfinite(ratio)
    return TheoryDifference(
        curve.dof,
        curve.direction,
        item,
        theory.label,
        *_largest(f, ratio, curve.phase_deg - labels.phase_deg),
        points=int(np.count_nonzero(used)),
        unmatched=int(np.count_nonzero(np.isfinite(T) & ~used)),
        near=int(np.count_nonzero(np.abs(labels.z) <= NEAR)),
        branches=labels.sentence,
        frequency_hz=f,
        magnitude=T,
        theory_magnitude=labels.transmissibility,
        deviation_percent=100 * (ratio - 1),
        branch=labels.branch,
        z=labels.z,
    )


def _largest(
    f: Array, ratio: Array, turn: Array
) -> tuple[float | None, float | None, float | None, float | None]:
    """Of `ratio` (n,) - 1 the rms in percent, the largest and the frequency of that; the largest
    phase difference in degrees, to either side; None where nothing is finite."""
    used = np.isfinite(ratio)
    percent = 100 * np.abs(ratio[used] - 1)
    degrees = np.abs((turn[np.isfinite(turn)] + 180) % 360 - 180)
    phase = float(degrees.max()) if degrees.size else None
    if not percent.size:
        return None, None, None, phase
    rms = float(np.sqrt(np.mean(percent**2)))
    return rms, float(percent.max()), float(f[used][percent.argmax()]), phase


def _ascending(curve: Curve) -> tuple[Array, Array, Array]:
    """Frequency, T and unwrapped phase of the usable points, by rising frequency."""
    usable = np.isfinite(curve.frequency_hz) & np.isfinite(curve.magnitude) & (curve.magnitude > 0)
    f, first = np.unique(curve.frequency_hz[usable], return_index=True)
    phase = curve.phase_deg[usable][first]
    known = np.isfinite(phase)
    if np.any(known):
        phase = np.interp(f, f[known], np.unwrap(phase[known], period=360))
    return f, curve.magnitude[usable][first], phase


def _curve_differences(a: Labelled, b: Labelled) -> Iterator[CurveDifference]:
    """Every curve, paired by direction and order or noted as alone."""
    for dof, of_a, of_b in _paired_directions(a[1], b[1]):
        ones = [c for c in a[1].curves if (c.dof, c.direction) == (dof, of_a)]
        twos = [c for c in b[1].curves if (c.dof, c.direction) == (dof, of_b)]
        for one, two in zip_longest(ones, twos):
            if one and two:
                yield curve_difference(a[0], one, b[0], two)
            else:
                note = f'only in {a[0] if one else b[0]}'
                yield CurveDifference(dof, _joint(of_a, of_b), a[0], b[0], note=note)


def _event_differences(a: Labelled, b: Labelled) -> Iterator[EventDifference]:
    """Every event, paired nearest first or noted as alone."""
    for dof, of_a, of_b in _paired_directions(a[1], b[1]):
        for kind in dict.fromkeys(event.kind for event in (*a[1].events, *b[1].events)):
            ones = [e for e in a[1].events if (e.dof, e.direction, e.kind) == (dof, of_a, kind)]
            twos = [e for e in b[1].events if (e.dof, e.direction, e.kind) == (dof, of_b, kind)]
            for one, two in _nearest_first(ones, twos):
                yield EventDifference(
                    dof,
                    _joint(of_a, of_b),
                    kind,
                    a[0],
                    b[0],
                    a_hz=one.frequency_hz if one else None,
                    b_hz=two.frequency_hz if two else None,
                    difference_hz=two.frequency_hz - one.frequency_hz if one and two else None,
                    a_magnitude=one.magnitude if one else None,
                    b_magnitude=two.magnitude if two else None,
                    magnitude_percent=(
                        100 * (two.magnitude / one.magnitude - 1) if one and two else None
                    ),
                    resolution_hz=max(event.resolution_hz for event in (one, two) if event),
                    note='' if one and two else f'only in {a[0] if one else b[0]}',
                )


def _nearest_first(
    ones: Sequence[Event], twos: Sequence[Event]
) -> list[tuple[Event | None, Event | None]]:
    """Pairs by the smallest difference of frequency, in the order of `ones`; beside None what is
    left over."""

    def apart(pair: tuple[int, int]) -> float:
        return abs(ones[pair[0]].frequency_hz - twos[pair[1]].frequency_hz)

    left, right = list(range(len(ones))), list(range(len(twos)))
    partner: dict[int, Event] = {}
    while left and right:
        one, two = min(
            product(left, right),
            key=lambda ij: abs(ones[ij[0]].frequency_hz - twos[ij[1]].frequency_hz),
        )
        partner[one] = twos[two]
        left.remove(one)
        right.remove(two)
    pairs = [(one, partner.get(number)) for number, one in enumerate(ones)]
    return [*pairs, *((None, twos[number]) for number in right)]


def _paired_directions(a: Estimate, b: Estimate) -> Iterator[tuple[str, Direction, Direction]]:
    """(dof, direction in a, direction in b) for everything in either; None where one has nothing.

    Equal directions pair; then `none` (stepped or random excitation) pairs with one the other has
    left. Nothing is dropped.
    """
    mine, theirs = _directions(a), _directions(b)
    for dof in sorted({*mine, *theirs}, key=dof_order):
        left, right = mine.get(dof, []), theirs.get(dof, [])
        yield from ((dof, direction, direction) for direction in left if direction in right)
        # `none` comes first of those without a partner
        lone = [d for d in left if d not in right], [d for d in right if d not in left]
        only_a, only_b = (sorted(directions, key='none'.__ne__) for directions in lone)
        if only_a and only_b and 'none' in (only_a[0], only_b[0]):
            yield dof, only_a.pop(0), only_b.pop(0)
        yield from ((dof, direction, None) for direction in only_a)
        yield from ((dof, None, direction) for direction in only_b)


def _directions(estimate: Estimate) -> dict[str, list[str]]:
    """The directions of each degree of freedom, in order of appearance."""
    items: tuple[Curve | Event, ...] = (*estimate.curves, *estimate.events)
    pairs = dict.fromkeys((item.dof, item.direction) for item in items)
    return {dof: [way for of, way in pairs if of == dof] for dof, _ in pairs}


def _joint(a: Direction, b: Direction) -> str:
    """The direction of a row: one word, or both where they differ."""
    return '/'.join(dict.fromkeys(direction for direction in (a, b) if direction))


def _table(caption: str, labels: int, columns: Columns, rows: Sequence[Any]) -> Table:
    cells = tuple(tuple(cell(row) for cell in columns.values()) for row in rows)
    return Table(caption, tuple(columns), cells, labels).trimmed()
