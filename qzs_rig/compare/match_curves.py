"""How far two measured curves lie from each other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import zip_longest

import numpy as np

from qzs_rig.estimation.estimate import Curve, Estimate, Event
from qzs_rig.report.names import dof_name, dof_order
from qzs_rig.report.table import Table, number
from qzs_rig.samples import Array

Direction = str | None
"""None: the run has nothing there."""


def paired_directions(a: Estimate, b: Estimate) -> list[tuple[str, Direction, Direction]]:
    """(dof, direction in a, direction in b) for everything in either; None where one has nothing.

    Equal directions pair; then `none` (stepped or random excitation) pairs with one the other has
    left. Nothing is dropped.
    """
    mine, theirs = _directions(a), _directions(b)
    pairs: list[tuple[str, Direction, Direction]] = []
    for dof in sorted({*mine, *theirs}, key=dof_order):
        left, right = mine.get(dof, []), theirs.get(dof, [])
        pairs += [(dof, direction, direction) for direction in left if direction in right]
        lone_left = [direction for direction in left if direction not in right]
        lone_right = [direction for direction in right if direction not in left]
        if lone_left and lone_right and 'none' in (*lone_left, *lone_right):
            lone_left.sort(key='none'.__ne__)
            lone_right.sort(key='none'.__ne__)
            pairs.append((dof, lone_left.pop(0), lone_right.pop(0)))
        pairs += [(dof, direction, None) for direction in lone_left]
        pairs += [(dof, None, direction) for direction in lone_right]
    return pairs


def joint(a: Direction, b: Direction) -> str:
    """The direction of a row: one word, or both where they differ."""
    return '/'.join(dict.fromkeys(direction for direction in (a, b) if direction))


def _directions(estimate: Estimate) -> dict[str, list[str]]:
    directions: dict[str, list[str]] = {}
    items: tuple[Curve | Event, ...] = (*estimate.curves, *estimate.events)
    for item in items:
        seen = directions.setdefault(item.dof, [])
        if item.direction not in seen:
            seen.append(item.direction)
    return directions


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


def curve_differences(
    a: tuple[str, Estimate], b: tuple[str, Estimate]
) -> Iterator[CurveDifference]:
    """Every curve of the labelled estimates, paired by direction and order or noted as alone."""
    for dof, of_a, of_b in paired_directions(a[1], b[1]):
        ones = [c for c in a[1].curves if (c.dof, c.direction) == (dof, of_a)]
        twos = [c for c in b[1].curves if (c.dof, c.direction) == (dof, of_b)]
        for one, two in zip_longest(ones, twos):
            if one and two:
                yield curve_difference(a[0], one, b[0], two)
            else:
                note = f'only in {a[0] if one else b[0]}'
                yield CurveDifference(dof, joint(of_a, of_b), a[0], b[0], note=note)


def curve_difference(a_label: str, a: Curve, b_label: str, b: Curve) -> CurveDifference:
    """`b` against `a`, on the points of both within the common range: log T and unwrapped phase
    are interpolated linearly in frequency, unusable (NaN) points left out."""
    head = (a.dof, joint(a.direction, b.direction), a_label, b_label)
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
    percent = 100 * np.abs(ratio - 1)
    phase = wrapped(np.interp(grid, fb, pb) - np.interp(grid, fa, pa))
    finite = np.abs(phase[np.isfinite(phase)])
    same = (a.quantity, a.estimator) == (b.quantity, b.estimator)
    return CurveDifference(
        *head,
        rms_percent=float(np.sqrt(np.mean(percent**2))),
        max_percent=float(np.max(percent)),
        max_at_hz=float(grid[np.argmax(percent)]),
        max_phase_deg=float(np.max(finite)) if finite.size else None,
        frequency_hz=(float(low), float(high)),
        points=len(grid),
        note='' if same else f'{a.estimator} {a.quantity} against {b.estimator} {b.quantity}',
    )


def curve_table(rows: Sequence[CurveDifference]) -> Table:
    """`rows` for the eye."""
    header = ('degree of freedom', 'direction', 'a', 'b', 'rms %', 'max %', 'at Hz', 'phase °')
    return Table(
        'Transmissibility of b against a, over their common range',
        (*header, 'from Hz', 'to Hz', 'remark'),
        tuple(
            (
                dof_name(row.dof),
                row.direction,
                row.a,
                row.b,
                number(row.rms_percent, '.2f'),
                number(row.max_percent, '.2f'),
                number(row.max_at_hz),
                number(row.max_phase_deg, '.1f'),
                *(number(edge) for edge in row.frequency_hz or (None, None)),
                row.note,
            )
            for row in rows
        ),
        labels=4,
    )


def _ascending(curve: Curve) -> tuple[Array, Array, Array]:
    """Frequency, T and unwrapped phase of the usable points, by rising frequency."""
    usable = np.isfinite(curve.frequency_hz) & np.isfinite(curve.magnitude) & (curve.magnitude > 0)
    f, first = np.unique(curve.frequency_hz[usable], return_index=True)
    phase = curve.phase_deg[usable][first]
    known = np.isfinite(phase)
    if np.any(known):
        phase = np.interp(f, f[known], np.unwrap(phase[known], period=360))
    return f, curve.magnitude[usable][first], phase


def wrapped(degrees: Array) -> Array:
    """The same angles in [-180, 180)."""
    return np.asarray((degrees + 180) % 360 - 180)
