"""Theory curves in the units of the measurement: hertz, metres or radians, degrees."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from qzs_rig.errors import InputError
from qzs_rig.theory.single_term import SingleTerm, folds, single_term
from qzs_rig.timehistory import Array

HELD = {'displacement': 0, 'velocity': 1, 'acceleration': 2}
"""What the shaker holds constant over frequency f: the base moves amplitude / (2πf)^power."""


@dataclass(frozen=True)
class TheoryCurve:
    """Predicted transmissibility of one degree of freedom, drawn and matched branch by branch.

    `frequency_hz` is (n,), the others (n, b): column k is a path continuous in its rows, NaN where
    it does not exist. Frequencies need not ascend (a continued path turns around at its folds).
    `phase_deg` is top against base, `stable` says which points a platform can stay on.
    """

    dof: str
    label: str
    frequency_hz: Array
    magnitude: Array
    phase_deg: Array
    stable: NDArray[np.bool_]


@dataclass(frozen=True)
class TheoryCase:
    """One degree of freedom under the law c1 w + c3 w³, made dimensionless by `omega0` (rad/s) and
    `length` (m; 1 for a rotation). `amplitude` is the base's displacement, velocity or
    acceleration, as `held` says, in m or rad, per s or per s².

    For a rotation omega0 is sqrt(k1 L20 L0 / I), c1 and c3 those of the torque law M̂.
    """

    dof: str
    c1: float
    c3: float
    zeta: float
    omega0: float
    length: float
    amplitude: float
    held: str = 'displacement'
    label: str = 'theory, one harmonic'

    def __post_init__(self) -> None:
        if self.held not in HELD:
            raise InputError(f'held is {self.held!r}; known: {", ".join(HELD)}')
        for name in ('omega0', 'length'):
            if not getattr(self, name) > 0:
                raise InputError(f'{name} is {getattr(self, name)}; give a value above 0')

    def amplitude_at(self, frequency_hz: ArrayLike) -> Array:
        """Base displacement amplitude at `frequency_hz`, m or rad."""
        omega = 2 * np.pi * np.asarray(frequency_hz, dtype=np.float64)
        return np.asarray(self.amplitude / omega ** HELD[self.held])

    @property
    def amplitude_hat(self) -> float:
        """Ĥ at omega = omega0; it falls as (omega/omega0)^-HELD[held]."""
        return float(self.amplitude / self.omega0 ** HELD[self.held] / self.length)

    def folds_hz(self) -> Array:
        """Frequencies where branches meet and a sweep jumps, ascending."""
        law = (self.c1, self.c3, self.zeta, self.amplitude_hat)
        return folds(*law, HELD[self.held]) * self.omega0 / (2 * np.pi)


def theory_curve(
    case: TheoryCase, lowest_hz: float, highest_hz: float, n: int = 800
) -> TheoryCurve:
    """Branches of `case` from `lowest_hz` to `highest_hz`: lower, middle, upper in amplitude.

    About `n` points evenly spaced in the logarithm, and more towards the folds, so that the
    branches meet where they are drawn.
    """
    if not 0 < lowest_hz < highest_hz:
        raise InputError(f'theory range is {lowest_hz} to {highest_hz} Hz; give 0 < low < high')
    frequency_hz = np.geomspace(lowest_hz, highest_hz, n)
    for fold in case.folds_hz():
        # Branches part like a square root at a fold.
        near = fold * (1 + np.concatenate([-(d := np.geomspace(1e-10, 1e-2, 40)), d]))
        frequency_hz = np.concatenate([frequency_hz, near])
    inside = (frequency_hz >= lowest_hz) & (frequency_hz <= highest_hz)
    frequency_hz = np.unique(frequency_hz[inside])
    omega = 2 * np.pi * frequency_hz / case.omega0
    amplitude_hat = case.amplitude_at(frequency_hz) / case.length
    answer = single_term(case.c1, case.c3, case.zeta, amplitude_hat, omega)
    order = _continuous(answer)
    return TheoryCurve(
        case.dof,
        case.label,
        frequency_hz,
        np.take_along_axis(answer.T, order, axis=1),
        np.take_along_axis(answer.phase_deg, order, axis=1),
        np.take_along_axis(answer.stable, order, axis=1),
    )


def theory_curves(
    cases: Sequence[TheoryCase], lowest_hz: float, highest_hz: float
) -> tuple[TheoryCurve, ...]:
    """`theory_curve` of every case."""
    return tuple(theory_curve(case, lowest_hz, highest_hz) for case in cases)


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
