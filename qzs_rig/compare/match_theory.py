"""How far measured points lie from the theory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from qzs_rig.compare.angles import wrapped
from qzs_rig.compare.names import dof_name
from qzs_rig.compare.tables import Table, number
from qzs_rig.compare.theory_overlay import TheoryCurve
from qzs_rig.estimation.estimate import Curve
from qzs_rig.timehistory import Array


@dataclass(frozen=True)
class TheoryDifference:
    """Measured points against the nearest stable branch of `theory`, in percent of its T.

    The lists hold every measured point, in the curve's order; `theory_magnitude` and
    `deviation_percent` are NaN where no stable branch exists, counted by `unmatched`.
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
    frequency_hz: Array
    magnitude: Array
    theory_magnitude: Array
    deviation_percent: Array


def theory_difference(label: str, curve: Curve, theory: TheoryCurve) -> TheoryDifference:
    """Every measured point of `curve` against the stable branch of `theory` nearest in log T."""
    f, T = curve.frequency_hz, curve.magnitude
    expected, expected_phase = _nearest_stable(f, T, theory)
    deviation = 100 * (T / expected - 1)
    used = np.isfinite(deviation)
    size = np.abs(deviation[used])
    turn = np.abs(wrapped(curve.phase_deg - expected_phase))
    turn = turn[np.isfinite(turn)]
    return TheoryDifference(
        curve.dof,
        curve.direction,
        label,
        theory.label,
        rms_percent=float(np.sqrt(np.mean(size**2))) if size.size else None,
        max_percent=float(np.max(size)) if size.size else None,
        max_at_hz=float(f[used][np.argmax(size)]) if size.size else None,
        max_phase_deg=float(np.max(turn)) if turn.size else None,
        points=int(np.count_nonzero(used)),
        unmatched=int(np.count_nonzero(np.isfinite(T) & ~used)),
        frequency_hz=f,
        magnitude=T,
        theory_magnitude=expected,
        deviation_percent=deviation,
    )


def theory_table(rows: Sequence[TheoryDifference]) -> Table:
    """`rows` for the eye."""
    header = ('degree of freedom', 'direction', 'run', 'theory', 'rms %', 'max %', 'at Hz')
    return Table(
        'Measured transmissibility against the nearest stable branch of the theory',
        (*header, 'phase °', 'points', 'unmatched'),
        tuple(
            (
                dof_name(row.dof),
                row.direction,
                row.item,
                row.theory,
                number(row.rms_percent, '.2f'),
                number(row.max_percent, '.2f'),
                number(row.max_at_hz),
                number(row.max_phase_deg, '.1f'),
                str(row.points),
                str(row.unmatched),
            )
            for row in rows
        ),
        labels=4,
    )


def _nearest_stable(f: Array, T: Array, theory: TheoryCurve) -> tuple[Array, Array]:
    """T and phase of the nearest stable branch at each of `f` (n,), NaN where there is none."""
    start, end = _stable_segments(theory)
    if not len(f) or not len(start):
        return np.full(len(f), np.nan), np.full(len(f), np.nan)
    # In pieces: every point meets every segment.
    pieces = [slice(k, k + 256) for k in range(0, len(f), 256)]
    found = np.concatenate([_nearest_on(start, end, f[k], T[k]) for k in pieces])
    return found[:, 0], found[:, 1]


def _nearest_on(start: Array, end: Array, f: Array, T: Array) -> Array:
    """T and phase (n, 2) at `f`, on the segments `start` to `end` (m, 3) of frequency, T, phase."""
    span = end[:, 0] - start[:, 0]
    with np.errstate(divide='ignore', invalid='ignore'):
        share = (f[:, None] - start[:, 0]) / span
        within = (share >= 0) & (share <= 1)
        there = start[:, 1] * (end[:, 1] / start[:, 1]) ** np.clip(share, 0, 1)
        distance = np.abs(np.log(T[:, None] / there))
    distance = np.where(within & np.isfinite(distance), distance, np.inf)
    row, k = np.arange(len(f)), np.argmin(distance, axis=1)
    phase = start[k, 2] + share[row, k] * wrapped(end[k, 2] - start[k, 2])
    nearest = np.stack([there[row, k], phase], axis=1)
    return np.where(np.isfinite(distance[row, k])[:, None], nearest, np.nan)


def _stable_segments(theory: TheoryCurve) -> tuple[Array, Array]:
    """Both ends (m, 3) of all pieces of branch between stable neighbours: frequency, T, phase."""
    f = np.broadcast_to(theory.frequency_hz[:, None], theory.magnitude.shape)
    points = np.stack([f, theory.magnitude, theory.phase_deg], axis=-1)
    usable = theory.stable & np.isfinite(theory.magnitude) & (theory.magnitude > 0)
    both = usable[:-1] & usable[1:]
    return points[:-1][both], points[1:][both]
