"""Floquet multipliers of the coupled platform: twelve of them, by Magnus' fourth order series.

As `floquet` for one degree of freedom; here the exponentials are of matrices (12, 12), by scaling
and squaring of Taylor's series.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from qzs_rig.samples import Array
from qzs_rig.theory.coupled.balance import CoupledBalance
from qzs_rig.theory.coupled.plant import COORDINATES

STEPS_A_RADIAN = 3.0
"""Steps while the fastest disturbance turns by a radian."""
AT_ONCE = 512


def multipliers(balance: CoupledBalance, x: Array, omega: float) -> NDArray[np.complex128]:
    """(12,) over one period of the drive, largest first, of the motion with unknowns x."""
    rough = _rates(balance, x, omega, balance.angle)
    fastest = float(np.abs(np.linalg.eigvals(rough[:: max(1, len(rough) // 8)])).max())
    wanted = max(balance.basis.samples, STEPS_A_RADIAN * 2 * np.pi * fastest / omega, 64)
    steps = 1 << int(np.ceil(np.log2(wanted)))
    whole = np.eye(2 * COORDINATES)
    for first in range(0, steps, AT_ONCE):
        places = np.arange(first, min(first + AT_ONCE, steps))
        maps = _maps(balance, x, omega, places, steps)
        while len(maps) > 1:
            maps = maps[1::2] @ maps[::2]
        whole = maps[0] @ whole
    found = np.linalg.eigvals(whole)
    return np.asarray(found[np.argsort(-np.abs(found))], dtype=np.complex128)


def _maps(
    balance: CoupledBalance, x: Array, omega: float, places: NDArray[np.int64], steps: int
) -> Array:
    h, side = 2 * np.pi / (steps * omega), np.sqrt(3) / 6
    first, second = (
        _rates(balance, x, omega, 2 * np.pi * (places + 0.5 + s) / steps) for s in (-side, side)
    )
    bend = second @ first - first @ second
    return _exponential(0.5 * h * (first + second) + np.sqrt(3) / 12 * h**2 * bend)


def _rates(balance: CoupledBalance, x: Array, omega: float, angle: Array) -> Array:
    """(n, 12, 12): the linear rates of a small disturbance and its velocity."""
    place, speed, pull = np.moveaxis(
        balance.plate.slopes(*balance.motion(x, omega, angle), omega, angle), -1, 1
    )
    matrix = np.zeros((len(angle), 2 * COORDINATES, 2 * COORDINATES))
    matrix[:, :COORDINATES, COORDINATES:] = np.eye(COORDINATES)
    matrix[:, COORDINATES:] = -np.linalg.solve(pull, np.concatenate([place, speed], axis=-1))
    return matrix


def _exponential(matrix: Array) -> Array:
    """Of (n, 12, 12), to 4e-15 of scipy.linalg.expm, which works through a stack one by one
    and is sixteen times slower."""
    size = float(np.abs(matrix).sum(axis=-1).max())
    halvings = max(0, int(np.ceil(np.log2(max(size, 1e-300) / 0.25))))
    part = matrix / 2.0**halvings
    term = result = np.eye(matrix.shape[-1]) + part
    term = part
    for k in range(2, 11):
        term = term @ part / k
        result = result + term
    for _ in range(halvings):
        result = result @ result
    return np.asarray(result)
