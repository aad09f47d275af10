"""Floquet multipliers of the coupled platform, twelve of them, and the events that they tell.

Magnus' fourth order series as for one degree of freedom; here the exponentials are of matrices
(12, 12), by scaling and squaring of Taylor's series.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from qzs_rig.samples import Array
from qzs_rig.theory.balance.events import zero_between
from qzs_rig.theory.balance.newton import Equations, Point
from qzs_rig.theory.balance.response import Event
from qzs_rig.theory.coupled.plate import COORDINATES, CoupledBalance

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


@dataclass(frozen=True)
class PlateMotion:
    """BalanceEquations `x` of all six coordinates at `omega`."""

    balance: CoupledBalance
    x: np.ndarray[tuple[int], np.dtype[np.float64]]
    omega: float


@dataclass(frozen=True)
class PlateStretch:
    """Two neighbouring points of a path of `equations`, and what a point of it is as a whole."""

    equations: Equations
    here: Point
    ahead: Point
    whole: Callable[[Point], PlateMotion]


def fold(pair: PlateStretch, number: int) -> Event | None:
    """Where the path of branch `number` turns back between the two; None where it does not."""
    return _located(pair, lambda point: float(point.tangent[-1]), number, lambda _: 'fold')


def loss(pair: PlateStretch, number: int) -> Event | None:
    """Where the largest multiplier crosses the unit circle; None where it does not."""
    return _located(pair, lambda point: abs(_lead(pair, point)) - 1.0, number, _kind)


def onset(pair: PlateStretch, number: int) -> Event | None:
    """Where T = 1 between the two; None where it is not."""

    def excess(point: Point) -> float:
        return _event(pair, point, 'onset', number).T - 1.0

    return _located(pair, excess, number, lambda _: 'onset')


def _located(
    pair: PlateStretch,
    function: Callable[[Point], float],
    number: int,
    kind: Callable[[complex], str],
) -> Event | None:
    point = zero_between(pair.equations, pair.here, pair.ahead, function)
    return None if point is None else _event(pair, point, kind(_lead(pair, point)), number)


def _kind(lead: complex) -> str:
    if abs(lead.imag) < 1e-4:
        return 'period_doubling' if lead.real < 0 else 'symmetry_breaking'
    return 'neimark_sacker'


def _lead(pair: PlateStretch, point: Point) -> complex:
    at = pair.whole(point)
    return complex(multipliers(at.balance, at.x, at.omega)[0])


def _event(pair: PlateStretch, point: Point, kind: str, number: int) -> Event:
    at = pair.whole(point)
    top = at.balance.seen(at.x)
    u, v = complex(top[1], -top[2]), at.balance.plate.base(at.omega)
    return Event(
        omega=at.omega,
        T=abs(u) / v,
        kind=kind,
        amplitude=abs(u - v),
        phase_deg=float(np.degrees(np.angle(u))),
        branch=number,
        uncertainty=math.nan,
        coefficients=top,
    )
