"""Which branch of the theory each measured point lies on, and how far from it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from qzs_rig.estimation.estimate import Curve, Estimate
from qzs_rig.files import finite_or_none
from qzs_rig.prediction.curve import Branch, Prediction
from qzs_rig.samples import Array

SCHEMA = 'qzs_rig/match/1'
NONE = 'none'
NEAR = 2.0
"""|z| up to which a point counts as being on its branch."""


FAR = 2.0
"""Ratio of T from which a point is on no branch: in a jump, or in a motion of another period."""


@dataclass(frozen=True)
class Labels:
    """The points (n,) of one measured curve against the nearest stable branch of a prediction,
    nearest in the ratio of the transmissibilities.

    `branch` is its name, `none` where no stable one lies within a ratio of FAR;
    `transmissibility`, `phase_deg` are those of the branch, z is (measured - predicted) /
    uncertainty of the measured one: NaN where there is no branch or no stated uncertainty.
    """

    dof: str
    direction: str
    theory: str
    branch: tuple[str, ...]
    transmissibility: Array
    phase_deg: Array
    z: Array

    @property
    def counts(self) -> dict[str, tuple[int, int]]:
        """(points within NEAR, points) of every branch that has any."""
        near = np.abs(self.z) <= NEAR
        total = Counter(self.branch)
        within = Counter(name for name, close in zip(self.branch, near, strict=True) if close)
        return {name: (within[name], total[name]) for name in sorted(total)}

    @property
    def sentence(self) -> str:
        """`412 of 420 points within 2σ of the upper branch`; without σ where none is stated."""
        known = {name: count for name, count in self.counts.items() if name != NONE}
        stated = bool(np.isfinite(self.z).any())
        said = [
            f'{within} of {total} points within {NEAR:g}σ of the {name} branch'
            if stated
            else f'{total} points on the {name} branch'
            for name, (within, total) in known.items()
        ]
        lost = self.counts.get(NONE)
        return ', '.join(said + ([f'{lost[1]} on no branch'] if lost else []))


def label(curve: Curve, prediction: Prediction) -> Labels:
    """The points of `curve` on `prediction`, which is of the same degree of freedom."""
    f, measured = curve.frequency_hz, curve.magnitude
    names = [*(branch.name for branch in prediction.branches), NONE]
    T, phase = _table(f, prediction.branches)
    with np.errstate(divide='ignore', invalid='ignore'):
        gap = np.abs(np.log(measured / T))
        gap = np.where(gap < np.log(FAR), gap, np.inf)
        nearest = np.argmin(gap, axis=0)
        row = np.arange(len(f))
        nearest = np.where(np.isfinite(gap[nearest, row]), nearest, len(names) - 1)
        z = (measured - T[nearest, row]) / curve.uncertainty
    return Labels(
        curve.dof,
        curve.direction,
        prediction.label,
        tuple(names[k] for k in nearest.tolist()),
        T[nearest, row],
        phase[nearest, row],
        np.where(np.isfinite(z), z, np.nan),
    )


def label_all(estimate: Estimate, predictions: Sequence[Prediction]) -> list[Labels]:
    """`label` of every curve that has a prediction."""
    return [
        label(curve, prediction)
        for curve in estimate.curves
        for prediction in predictions
        if prediction.dof == curve.dof
    ]


def to_document(run_id: str, labels: Sequence[Labels]) -> dict[str, Any]:
    """JSON-ready, the content of `match.json`: curve by curve in the order of `estimate.json`."""
    return {
        'schema': SCHEMA,
        'run_id': run_id,
        'curves': [
            {
                'dof': item.dof,
                'direction': item.direction,
                'theory': item.theory,
                'summary': item.sentence,
                'branch': list(item.branch),
                'z': finite_or_none(item.z),
                'transmissibility': finite_or_none(item.transmissibility),
                'phase_deg': finite_or_none(item.phase_deg),
            }
            for item in labels
        ],
    }


def _table(f: Array, branches: Sequence[Branch]) -> tuple[Array, Array]:
    """T and phase of all branches at `f`, (branches + 1, n) each; the last row is NaN."""
    nothing = np.full(len(f), np.nan)
    T = [np.exp(b.at(f, np.log(b.transmissibility))) for b in branches]
    phase = [b.at(f, np.unwrap(b.phase_deg, period=360)) for b in branches]
    turned = [np.asarray(180 - (180 - row) % 360) for row in phase]
    return np.stack([*T, nothing]), np.stack([*turned, nothing])
