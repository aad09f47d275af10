"""The paper's one-term balance (29)-(32) over a range, in the form of the full response."""

from __future__ import annotations

import numpy as np

from qzs_rig.errors import InputError
from qzs_rig.samples import Array
from qzs_rig.theory.balance.continuation import Ending, Stop
from qzs_rig.theory.balance.response import Branch, Event, FrequencyResponse, peak_among
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.theory.single_term import SingleTerm, folds, onset_omega, single_term

POINTS = 1200


def single_term_response(oscillator: Oscillator, low: float, high: float) -> FrequencyResponse:
    """Lower, middle and upper motions of c1 w + c3 w³, the law's odd terms, each a branch.

    Raises InputError for a load, which the paper's balance has no place for.
    """
    if oscillator.load:
        raise InputError(
            f'the single-term balance knows no load ({oscillator.load:.4g}); leave out '
            'platform.payload_trim, or --single-term'
        )
    c1, c3 = oscillator.law.cubic(oscillator.design)[oscillator.number]
    law = c1, c3, oscillator.zeta
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
    """Even in the logarithm, round ones so that tables can be read off, and both sides of folds."""
    step = 10.0 ** np.floor(np.log10(high)) / 200
    rounds = np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step
    both = np.concatenate([edges * (1 - 1e-12), edges * (1 + 1e-12)])
    grid = np.concatenate([np.geomspace(low, high, POINTS), np.round(rounds, 12), both])
    return np.unique(grid[(grid >= low) & (grid <= high)])


def _count(answer: SingleTerm) -> int:
    return int(np.isfinite(answer.W[0]).sum())


def _branches(answer: SingleTerm, oscillator: Oscillator) -> tuple[Branch, ...]:
    found = []
    for column in range(3):
        there = np.isfinite(answer.W[:, column])
        edges = np.flatnonzero(np.diff(there.astype(int))) + 1
        for part in np.split(np.arange(len(there)), edges):
            if there[part[0]]:
                found.append(_branch(answer, slice(part[0], part[-1] + 1), column, oscillator))
    return tuple(found)


def _branch(answer: SingleTerm, place: slice, column: int, own: Oscillator) -> Branch:
    omega, T = answer.omega[place], answer.T[place, column]
    phase = answer.phase_deg[place, column]
    w = own.base(omega) * (T * np.exp(1j * np.radians(phase)) - 1.0)
    coefficients = np.stack([np.zeros_like(T), w.real, -w.imag], axis=1)
    unknown = np.full((len(T), 2), np.nan + 0j)
    return Branch(
        omega, omega, T, answer.W[place, column], phase, answer.stable[place, column], coefficients,
        np.ones(len(T), dtype=np.int64), unknown, True, (Ending(Stop.RANGE),) * 2,
    )  # fmt: skip
