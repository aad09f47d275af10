"""The prediction in one harmonic, of the cubic part of the restoring law."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from qzs_rig.prediction import curve
from qzs_rig.prediction.curve import Branch, Prediction
from qzs_rig.prediction.scale import Scale
from qzs_rig.samples import Array
from qzs_rig.theory import single_term
from qzs_rig.theory.single_term import SingleTerm

METHOD, LABEL = 'single_term', 'theory, one harmonic'
POINTS = 400


def predict(scale: Scale, c1: float, c3: float, zeta: float) -> Prediction:
    """The balance (29) of the law c1 w + c3 w³ over the range of `scale`.

    Exact (to one harmonic) for cubic laws; with c1, c3 of another law good where the relative
    motion is small against the platform.
    """
    law = (c1, c3, zeta)
    held = (scale.amplitude, scale.falloff)
    omega = _grid(scale, single_term.folds(*law, *held))
    answer = single_term.single_term(*law, scale.amplitude * omega**-scale.falloff, omega)
    onset = single_term.onset_omega(*law, *held)
    branches = curve.named(_branches(answer, scale))
    return Prediction(
        scale.dof,
        LABEL,
        METHOD,
        branches,
        curve.folds(branches, scale.low_hz, scale.high_hz),
        () if onset is None else (onset * scale.hertz,),
    )


def _grid(scale: Scale, folds: Array) -> Array:
    """Ω evenly in the logarithm, and closer to the folds, where branches part like a root."""
    omega = np.geomspace(scale.omega(scale.low_hz), scale.omega(scale.high_hz), POINTS)
    near = np.geomspace(1e-10, 1e-2, 40)
    grid = np.unique(np.concatenate([omega, *(fold * (1 - near) for fold in folds),
                                     *(fold * (1 + near) for fold in folds)]))  # fmt: skip
    return np.asarray(grid[(grid >= omega[0]) & (grid <= omega[-1])])


def _branches(answer: SingleTerm, scale: Scale) -> list[Branch]:
    order = continuous(answer)
    T, phase, W = (
        np.take_along_axis(values, order, axis=1)
        for values in (answer.T, answer.phase_deg, answer.W)
    )
    stable = np.take_along_axis(answer.stable, order, axis=1)
    hz, stroke = answer.omega * scale.hertz, scale.length * W
    return [
        Branch('', hz[on], T[on, k], phase[on, k], stroke[on, k], stable[on, k])
        for k in range(T.shape[1])
        for on in _runs(np.isfinite(T[:, k]))
    ]


def continuous(answer: SingleTerm) -> NDArray[np.intp]:
    """Column order (n, 3) that puts a lone root on the branch it continues, lower or upper.

    Three roots are lower, middle, upper. A run of lone roots takes the branch it meets in
    amplitude where the three begin or end, and changes over halfway if its two ends disagree;
    without any fold it is the lower one.
    """
    three = np.isfinite(answer.W[:, 2])
    upper = np.zeros(len(three), dtype=bool)
    edges = np.flatnonzero(np.diff(three)) + 1
    for first, last in zip([0, *edges], [*edges, len(three)], strict=True):
        if not three[first] and (first > 0 or last < len(three)):
            left = _is_upper(answer, first, first - 1) if first > 0 else None
            right = _is_upper(answer, last - 1, last) if last < len(three) else left
            middle = (first + last) // 2
            upper[first:middle] = right if left is None else left
            upper[middle:last] = right
    return np.where(upper[:, None], np.array([1, 2, 0]), np.array([0, 1, 2]))


def _is_upper(answer: SingleTerm, lone: int, beside: int) -> bool:
    """Whether the one root of row `lone` continues the upper branch of row `beside`."""
    gap = np.abs(np.log(answer.W[beside] / answer.W[lone, 0]))
    return bool(gap[2] < gap[0])


def _runs(flags: NDArray[np.bool_]) -> list[slice]:
    """Every run of True that is longer than one."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]])))
    pairs = zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
    return [slice(first, last) for first, last in pairs if last - first > 1]
