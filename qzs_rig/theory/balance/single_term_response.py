"""The paper's one-term balance (29)-(32) over a range, in the form of the full response."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from qzs_rig.samples import Array
from qzs_rig.theory.balance.continuation import Ending, Stop
from qzs_rig.theory.balance.frequency_response import Branch, Event, FrequencyResponse, peak_among
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.theory.single_term import SingleTerm, folds, onset_omega, single_term

POINTS = 1200


def single_term_response(oscillator: Oscillator, low: float, high: float) -> FrequencyResponse:
    """Lower, middle and upper motions of c1 w + c3 w³, the odd terms of the law about its rest
    position, each a branch that ends at a fold or at the end of the range.

    Exact (to one harmonic) for cubic laws; for another law good where the relative motion is small
    against the platform.
    """
    law = *oscillator.cubic, oscillator.zeta
    edges = folds(*law, oscillator.amplitude, oscillator.falloff)
    edges = edges[(edges > low) & (edges < high)]
    omega = _frequencies(low, high, edges)
    answer = single_term(*law, oscillator.base(omega), omega)
    onset = onset_omega(*law, oscillator.amplitude, oscillator.falloff)
    branches = _branches(answer, oscillator)
    return FrequencyResponse(
        oscillator,
        low,
        high,
        branches,
        tuple(_fold(law, oscillator, float(edge)) for edge in edges),
        () if onset is None or not low <= onset <= high else (onset,),
        None,
        peak_among(branches),
    )


def _fold(law: tuple[float, float, float], own: Oscillator, edge: float) -> Event:
    sides = [np.array([edge * side]) for side in (1 - 1e-12, 1 + 1e-12)]
    inside = max((single_term(*law, own.base(side), side) for side in sides), key=_count)
    # the two motions that meet are the closest two
    first = int(np.argmin(np.diff(inside.W[0, : _count(inside)])))
    T, W, phase = (
        float(np.mean(part[0, first : first + 2]))
        for part in (inside.T, inside.W, inside.phase_deg)
    )
    return Event(edge, edge, T, 'fold', W, phase, 0, 0.0, np.empty(0))


def _frequencies(low: float, high: float, edges: Array) -> Array:
    """Even in the logarithm, round ones so that tables can be read off, and closer to the
    folds, where branches part like a root."""
    step = 10.0 ** np.floor(np.log10(high)) / 200
    rounds = np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step
    near = np.geomspace(1e-12, 1e-2, 50)
    close = [edge * (1 + side * near) for edge in edges for side in (-1, 1)]
    grid = np.concatenate([np.geomspace(low, high, POINTS), np.round(rounds, 12), *close])
    return np.unique(grid[(grid >= low) & (grid <= high)])


def _count(answer: SingleTerm) -> int:
    return int(np.isfinite(answer.W[0]).sum())


def _branches(answer: SingleTerm, oscillator: Oscillator) -> tuple[Branch, ...]:
    order, rows = _continuous(answer), np.arange(len(answer.omega))
    return tuple(
        _branch(answer, rows[place], order[place, k], oscillator)
        for k in range(3)
        for place in _runs(np.isfinite(answer.W[rows, order[:, k]]))
    )


def _continuous(answer: SingleTerm) -> NDArray[np.intp]:
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


def _branch(
    answer: SingleTerm, rows: NDArray[np.intp], columns: NDArray[np.intp], own: Oscillator
) -> Branch:
    omega, T = answer.omega[rows], answer.T[rows, columns]
    phase = answer.phase_deg[rows, columns]
    w = own.base(omega) * (T * np.exp(1j * np.radians(phase)) - 1.0)
    coefficients = np.stack([np.full_like(T, own.rest), w.real, -w.imag], axis=1)
    unknown = np.full((len(T), 2), np.nan + 0j)
    return Branch(
        omega, omega, T, answer.W[rows, columns], phase, answer.stable[rows, columns], coefficients,
        np.ones(len(T), dtype=np.int64), unknown, True, (Ending(Stop.RANGE),) * 2,
    )  # fmt: skip
