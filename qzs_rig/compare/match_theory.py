"""How far measured points lie from the theory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from qzs_rig.compare.match_curves import wrapped
from qzs_rig.estimation.estimate import Curve
from qzs_rig.prediction.curve import Prediction
from qzs_rig.prediction.labels import NEAR, label
from qzs_rig.report.names import dof_name
from qzs_rig.report.table import MISSING, Table, number
from qzs_rig.samples import Array


@dataclass(frozen=True)
class TheoryDifference:
    """Measured points against the nearest stable branch of `theory`, in percent of its T.

    The lists hold every measured point, in the curve's order: its `branch` (`none` where no
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


def theory_difference(item: str, curve: Curve, theory: Prediction) -> TheoryDifference:
    """Every measured point of `curve` against the stable branch of `theory` nearest in log T."""
    f, T = curve.frequency_hz, curve.magnitude
    labels = label(curve, theory)
    deviation = 100 * (T / labels.transmissibility - 1)
    used = np.isfinite(deviation)
    size = np.abs(deviation[used])
    turn = np.abs(wrapped(curve.phase_deg - labels.phase_deg))
    turn = turn[np.isfinite(turn)]
    return TheoryDifference(
        curve.dof,
        curve.direction,
        item,
        theory.label,
        rms_percent=float(np.sqrt(np.mean(size**2))) if size.size else None,
        max_percent=float(np.max(size)) if size.size else None,
        max_at_hz=float(f[used][np.argmax(size)]) if size.size else None,
        max_phase_deg=float(np.max(turn)) if turn.size else None,
        points=int(np.count_nonzero(used)),
        unmatched=int(np.count_nonzero(np.isfinite(T) & ~used)),
        near=int(np.count_nonzero(np.abs(labels.z) <= NEAR)),
        branches=labels.sentence,
        frequency_hz=f,
        magnitude=T,
        theory_magnitude=labels.transmissibility,
        deviation_percent=deviation,
        branch=labels.branch,
        z=labels.z,
    )


def theory_table(rows: Sequence[TheoryDifference]) -> Table:
    """`rows` for the eye."""
    header = ('degree of freedom', 'direction', 'run', 'theory', 'rms %', 'max %', 'at Hz')
    return Table(
        'Measured transmissibility against the nearest stable branch of the theory',
        (*header, 'phase °', 'points', 'unmatched', f'within {NEAR:g}σ', 'remark'),
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
                str(row.near) if np.isfinite(row.z).any() else MISSING,
                row.branches,
            )
            for row in rows
        ),
        labels=4,
    )
