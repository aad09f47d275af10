"""Stability of periodic motions: Floquet multipliers, and Hill's determinants for exact events.

A small disturbance is integrated over a period by Magnus' fourth order series (Blanes, Casas, Oteo
and Ros, Phys. Rep. 470 (2009) 151, section 5.4), every step of it at once.
By Hill's formula the determinant of the harmonic balance's slope has the sign of det(I - M), M the
monodromy matrix, and in half-odd orders that of det(I + M) (Bolotin 1964; Krack and Gross 2019).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from qzs_rig.samples import Array
from qzs_rig.theory.balance.basis import Basis, harmonics_of
from qzs_rig.theory.oscillator import Oscillator

STEPS_A_SWING = 48
"""Steps over the shortest swing of a disturbance; fourth order leaves about 1e-7 of it."""
AT_ONCE = 512
"""Steps of many degrees of freedom that are integrated side by side."""
SIDE = np.sqrt(3) / 6
"""Gauss' nodes lie so far, in steps, to both sides of the middle of a step."""


@dataclass(frozen=True)
class Stability:
    """Of n motions along a path: Floquet `multipliers` (n, m) over one period of the drive, which
    are `stable` (n,), and places (k,) `changes` after which the motion loses or wins stability
    other than by a fold."""

    multipliers: NDArray[np.complex128]
    stable: NDArray[np.bool_]
    changes: NDArray[np.intp]


@dataclass(frozen=True)
class Floquet:
    """Of n motions: `multipliers` (n, 2) over one period of the drive, and signed distances (n,)
    from instability: `same` is 0 at folds (disturbances in the waves of the motion), `other` where
    the period doubles, or, for motions in odd harmonics, where their symmetry breaks."""

    multipliers: NDArray[np.complex128]
    same: Array
    other: Array

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Where every small disturbance dies out."""
        return np.asarray((self.same > 0) & (self.other > 0))


def changes(flag: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Places (k,) after which `flag` (n,) is another."""
    return np.flatnonzero(flag[:-1] != flag[1:])


def linear(basis: Basis, zeta: float, omega: ArrayLike) -> Array:
    """(..., n, n) of w'' + 2 ζ w' in the n coefficients of `basis`."""
    frequency = np.asarray(omega, dtype=np.float64)[..., None, None]
    inertia = np.diag(basis.rates**2)
    return np.asarray(2 * zeta * frequency * basis.derivative - frequency**2 * inertia)


def tangent(
    basis: Basis, oscillator: Oscillator, motion: Basis, x: Array, omega: ArrayLike
) -> Array:
    """(..., n, n): what a small disturbance in `basis` of the motions x in `motion` feels."""
    slope = basis.tangent(stiffness(oscillator, x @ motion.to_time.T))
    return linear(basis, oscillator.zeta, omega) + slope


def stiffness(oscillator: Oscillator, w: Array) -> Array:
    """In the shape of w; a linear law's is one number."""
    found = oscillator.stiffness(w)
    return found if np.shape(found) == w.shape else np.full(w.shape, found)


def floquet(
    oscillator: Oscillator, omega: Array, coefficients: Array, odd: bool = False
) -> Floquet:
    """Of the motions `coefficients` (n, 2H + 1) at `omega` (n,); `odd` where they hold odd
    harmonics only, of an odd law: then half a period tells all."""
    size = max(1, len(omega) // 16)
    parts = [slice(k, k + size) for k in range(0, len(omega), size)]
    traces = [_trace(oscillator, omega[part], coefficients[part], odd) for part in parts]
    trace = np.concatenate([np.empty(0), *traces])
    share = 0.5 if odd else 1.0
    D = np.exp(-4 * np.pi * share * oscillator.zeta / omega)
    # as a product: the square of a multiplier of an overdamped tipping plate overflows
    edge, half = 2 * np.sqrt(D), trace.astype(np.complex128)
    root = np.sqrt(half - edge) * np.sqrt(half + edge)
    found = np.asarray(np.stack([trace + root, trace - root], axis=-1) / 2, dtype=np.complex128)
    if odd:
        # odd waves change sign over half a period, even ones do not
        with np.errstate(over='ignore', invalid='ignore'):
            return Floquet(found**2, 1 + D + trace, 1 + D - trace)
    return Floquet(found, 1 + D - trace, 1 + D + trace)


def determinants(
    oscillator: Oscillator, omega: float, coefficients: Array, odd: bool = False
) -> tuple[float, float]:
    """Hill's, with the signs and zeros of Floquet's `same` and `other`, of one motion (2H + 1,).

    As exact as the motion itself: what an event is located by.
    """
    motion = (Basis.odd if odd else Basis.full)(harmonics_of(coefficients))
    x = coefficients[motion.columns]
    values = []
    for basis in (motion, motion.even() if odd else motion.doubled()):
        matrix = tangent(basis, oscillator, motion, x, omega)
        scale = 1.0 + (omega * basis.rates) ** 2
        sign, logarithm = np.linalg.slogdet(matrix / scale[:, None])
        values.append(float(sign * np.exp(logarithm)))
    return values[0], values[1]


def multipliers(
    rates: Callable[[Array], Array], omega: float, wanted: float
) -> NDArray[np.complex128]:
    """(m,) over one period, largest first, in `wanted` steps or more; `rates` gives the linear
    rates (n, m, m) of a disturbance at phases (n,) of the drive."""
    steps = _power_of_two(wanted)
    h, whole = 2 * np.pi / (steps * omega), np.eye(1)
    for first in range(0, steps, AT_ONCE):
        middle = np.arange(first, min(first + AT_ONCE, steps)) + 0.5
        before, after = (rates(2 * np.pi * (middle + side) / steps) for side in (-SIDE, SIDE))
        bend = after @ before - before @ after
        part = _product(_exponential(0.5 * h * (before + after) + 0.5 * SIDE * h**2 * bend))
        whole = part if first == 0 else part @ whole
    found = np.linalg.eigvals(whole)
    return np.asarray(found[np.argsort(-np.abs(found))], dtype=np.complex128)


def _power_of_two(steps: float) -> int:
    return 1 << int(np.ceil(np.log2(steps)))


def _product(maps: Array) -> Array:
    """(..., m, m): all of the maps (..., steps, m, m), the first one first."""
    while maps.shape[-3] > 1:
        maps = maps[..., 1::2, :, :] @ maps[..., ::2, :, :]
    return maps[..., 0, :, :]


def _trace(oscillator: Oscillator, omega: Array, x: Array, odd: bool) -> Array:
    """Trace (n,) of the map of a disturbance over a period, or with `odd` half of one."""
    basis, share = Basis.full(harmonics_of(x)), 0.5 if odd else 1.0
    rough = np.abs(oscillator.stiffness(x @ basis.to_time.T)).max()
    swings = share * float(np.sqrt(rough) / omega.min())
    steps = _power_of_two(max(basis.samples, STEPS_A_SWING * swings, 64))
    h = 2 * np.pi * share / (steps * omega)[:, None]
    w = (x @ _at_nodes(basis, steps, share).T).reshape(len(x), 2, steps)
    first, second = np.moveaxis(stiffness(oscillator, w), 1, 0) - oscillator.zeta**2
    whole = _product(_exponentials(h, 0.5 * (first + second), 0.5 * SIDE * h**2 * (second - first)))
    decay = np.exp(-oscillator.zeta * h[:, 0] * steps)
    return np.asarray(decay * (whole[:, 0, 0] + whole[:, 1, 1]))


@lru_cache(maxsize=8)
def _at_nodes(basis: Basis, steps: int, share: float) -> Array:
    """(2 steps, coefficients): the waves at both of Gauss' nodes in each of so many steps."""
    middle = np.arange(steps) + 0.5
    return basis.waves(np.concatenate([middle - SIDE, middle + SIDE]) * share / steps)


def _exponentials(h: Array, k: Array, skew: Array) -> Array:
    """(n, steps, 2, 2): exp of [[skew, h], [-h k, -skew]], of trace 0."""
    root = np.sqrt((skew**2 - h**2 * k).astype(complex))
    with np.errstate(invalid='ignore', divide='ignore'):
        slope = np.where(root == 0, 1.0, np.sinh(root) / root).real
    level = np.cosh(root).real
    maps = np.empty((*k.shape, 2, 2))
    maps[..., 0, 0], maps[..., 0, 1] = level + slope * skew, slope * h
    maps[..., 1, 0], maps[..., 1, 1] = -slope * h * k, level - slope * skew
    return maps


def _exponential(matrix: Array) -> Array:
    """Of (n, m, m) by scaling and squaring of Taylor's series, to 4e-15 of scipy.linalg.expm, which
    works through a stack one by one and is sixteen times slower."""
    size = float(np.abs(matrix).sum(axis=-1).max())
    halvings = max(0, int(np.ceil(np.log2(max(size, 1e-300) / 0.25))))
    term = part = matrix / 2.0**halvings
    result: Any = np.eye(matrix.shape[-1]) + part
    for k in range(2, 11):
        term = term @ part / k
        result = result + term
    for _ in range(halvings):
        result = result @ result
    return np.asarray(result)
