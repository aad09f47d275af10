"""Steady motions at one frequency while amplitude, damping or a ratio of the design varies."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import InputError
from qzs_rig.samples import Array
from qzs_rig.theory.balance import seeds
from qzs_rig.theory.balance.events import Stretch, locate, turning
from qzs_rig.theory.balance.floquet import floquet
from qzs_rig.theory.balance.follow import Followed, Task, follow, refined
from qzs_rig.theory.balance.harmonic_balance import transmissibility
from qzs_rig.theory.balance.one_thread import one_thread
from qzs_rig.theory.balance.symmetry import lopsided, symmetric
from qzs_rig.theory.balance.unknowns import PARAMETERS, with_value
from qzs_rig.theory.oscillator import Oscillator


@dataclass(frozen=True)
class VariedBranch:
    """Motions along a path over `value` (n,) of the parameter; the rest as in response.Branch."""

    value: Array
    T: Array
    amplitude: Array
    phase_deg: Array
    stable: NDArray[np.bool_]
    coefficients: Array
    reasons: tuple[str, str]
    folds: tuple[float, ...]


@dataclass(frozen=True)
class VariedResponse:
    """All branches at `omega` over `parameter` that reach one of its bounds."""

    oscillator: Oscillator
    parameter: str
    omega: float
    branches: tuple[VariedBranch, ...]


@one_thread
def varied_response(
    oscillator: Oscillator, omega: float, parameter: str, low: float, high: float
) -> VariedResponse:
    """Motions at `omega` for `parameter` (one of PARAMETERS but omega) within [low, high].

    Raises InputError for another parameter, and for a range that does not rise from above 0.
    """
    if parameter not in PARAMETERS[1:]:
        raise InputError(f'unknown parameter {parameter!r}; known: {", ".join(PARAMETERS[1:])}')
    if not 0.0 < low < high < math.inf:
        raise InputError(f'{parameter} {low:g}:{high:g}: give a range that rises from above 0')
    found: list[tuple[Followed, Task]] = []
    for value in (high, low):
        at = with_value(oscillator, parameter, value)
        for _, x in seeds.one_term(at, np.array([omega])):
            task = Task(at, omega, x, low, high, parameter=parameter)
            start = refined(task)
            if start is None or any(_reaches(path, value, start) for path, _ in found):
                continue
            odd = symmetric(at) and lopsided(start) < 1e-6
            task = replace(task, coefficients=start, odd=odd)
            found.append((follow(task), task))
    return VariedResponse(
        oscillator, parameter, omega, tuple(_branch(path, task) for path, task in found)
    )


def _reaches(path: Followed, value: float, x: Array) -> bool:
    size = float(np.linalg.norm(x))
    for end in (0, -1):
        other = path.coefficients[end]
        n = min(len(x), len(other))
        near = float(np.linalg.norm(x[:n] - other[:n])) < 1e-5 * size
        if near and abs(path.omega[end] / value - 1.0) < 1e-9:
            return True
    return False


def _branch(path: Followed, task: Task) -> VariedBranch:
    omega = np.array([task.omega])
    ratio, stable = np.empty(len(path.omega), dtype=complex), np.empty(len(path.omega), dtype=bool)
    for k, (value, x) in enumerate(zip(path.omega, path.coefficients, strict=True)):
        at = with_value(task.oscillator, task.parameter, float(value))
        ratio[k] = transmissibility(at, omega, x[None])[0]
        stable[k] = floquet(at, omega, x[None], task.odd).stable[0]
    return VariedBranch(
        path.omega,
        np.abs(ratio),
        np.hypot(path.coefficients[:, 1], path.coefficients[:, 2]),
        np.degrees(np.angle(ratio)),
        stable,
        path.coefficients,
        path.reasons,
        _folds(path, task),
    )


def _folds(path: Followed, task: Task) -> tuple[float, ...]:
    rising = np.diff(path.omega) > 0
    found = []
    for k in np.flatnonzero(rising[:-1] != rising[1:]) + 1:
        for place in (k - 1, k):
            pair = slice(place, place + 2)
            needed = int(path.harmonics[pair].max())
            piece = Stretch(task.unknowns, path.omega[pair], path.coefficients[pair], needed)
            at = locate(piece, turning)
            if at is not None:
                found.append(at.omega)
                break
    return tuple(found)
