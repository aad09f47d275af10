"""The prediction in one harmonic, of the cubic part of the restoring law."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from qzs_rig.prediction import curve
from qzs_rig.prediction.curve import Branch, Prediction
from qzs_rig.samples import Array
from qzs_rig.theory import single_term
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.theory.single_term import SingleTerm

METHOD, LABEL = 'single_term', 'theory, one harmonic'
POINTS = 400


def predict(own: Oscillator, low_hz: float, high_hz: float) -> Prediction:
    """The balance (29) of the odd cubic part of the law about its rest position.

    Exact (to one harmonic) for cubic laws; for another law good where the relative motion is
    small against the platform.
    """
    law = (*own.cubic, own.zeta)
    held = (own.amplitude, own.falloff)
    omega = _grid(own.omega(low_hz), own.omega(high_hz), single_term.folds(*law, *held))
    answer = single_term.single_term(*law, own.base(omega), omega)
    onset = single_term.onset_omega(*law, *held)
    branches = curve.named(_branches(answer, own))
    return Prediction(
        own.dof,
        LABEL,
        METHOD,
        branches,
        curve.folds(branches, low_hz, high_hz),
        () if onset is None else (onset * own.hertz,),
    )


def _grid(low: float, high: float, folds: Array) -> Array:
    """Ω evenly in the logarithm, and closer to the folds, where branches part like a root."""
    omega = np.geomspace(low, high, POINTS)
    near = np.geomspace(1e-10, 1e-2, 40)
    grid = np.unique(np.concatenate([omega, *(fold * (1 - near) for fold in folds),
                                     *(fold * (1 + near) for fold in folds)]))  # fmt: skip
    return np.asarray(grid[(grid >= omega[0]) & (grid <= omega[-1])])


def _branches(answer: SingleTerm, own: Oscillator) -> list[Branch]:
    order = continuous(answer)
    T, phase, W = (
        np.take_along_axis(values, order, axis=1)
        for values in (answer.T, answer.phase_deg, answer.W)
    )
    stable = np.take_along_axis(answer.stable, order, axis=1)
    hz, stroke = answer.omega * own.hertz, own.length * W
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
