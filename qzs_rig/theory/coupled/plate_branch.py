"""Branches of the coupled platform, followed in all six coordinates."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from qzs_rig.samples import Array
from qzs_rig.theory.balance import continuation, newton
from qzs_rig.theory.balance.basis import resized
from qzs_rig.theory.balance.continuation import Ending, Steps, Stop
from qzs_rig.theory.balance.newton import Point
from qzs_rig.theory.balance.response import FrequencyResponse
from qzs_rig.theory.coupled.plate import COORDINATES, CoupledBalance, Plate

LADDER = (5, 9, 15, 21)
"""Numbers of harmonics that are tried."""
TAIL = 1e-7
"""The last two harmonics over all that moves, above which more are taken."""
FURTHEST_TILT = 0.5
"""Sine of half the angle, about 1 rad, beyond which arms would collide."""
LOOSE = 1e-3
"""Tail at which a motion is beyond so few harmonics, and its branch ends."""
STEPS = Steps(first=0.02, largest=0.1, turn=0.25, most=250)


@dataclass(frozen=True)
class PlateBranch:
    """Points of one branch, from low frequency, and why it ended at its first and last one."""

    balance: CoupledBalance
    points: list[Point]
    ends: tuple[Ending, Ending]


def plate_branches(
    plate: Plate, alone: FrequencyResponse, harmonics: int | None
) -> list[PlateBranch]:
    """Branches through the ends of the range, started where the branches `alone` of the projected
    degree of freedom end, and from a plate that hangs still in space."""
    found: list[PlateBranch] = []
    for omega in (alone.high, alone.low):
        for start in _starts(plate, alone, omega):
            x = _converged(plate, omega, start)
            if x is not None and not any(
                _reaches(plate_branch, omega, x) for plate_branch in found
            ):
                found.append(_followed(plate, omega, x, alone.low, alone.high, harmonics))
    return found


def _starts(plate: Plate, alone: FrequencyResponse, omega: float) -> list[Array]:
    balance = CoupledBalance(plate, LADDER[1])
    still = balance.resting().reshape(COORDINATES, -1)
    starts = [still.ravel()]
    for branch in alone.branches:
        for end in (0, -1):
            if branch.omega[end] == omega:
                top = resized(branch.coefficients[end], balance.harmonics)
                top[1] += plate.base(omega)
                starts.append(_moving(plate, still, top).ravel())
    return starts


def _moving(plate: Plate, still: Array, top: Array) -> Array:
    x = np.array(still)
    height = plate.scaled.height
    if plate.dof == 'horizontal':
        x[0] += top
    elif plate.dof == 'vertical_rotation':
        x[5] += 0.5 * top
    else:
        x[4] += 0.5 * top
        x[0] += height * top
    return x


def _converged(plate: Plate, omega: float, x: Array) -> Array | None:
    balance = CoupledBalance(plate, LADDER[1])
    found = newton.solve(balance, x, math.log(omega))
    if found is None or balance.tail(found) > LOOSE:
        return None
    return found


def _reaches(plate_branch: PlateBranch, omega: float, x: Array) -> bool:
    small = CoupledBalance(plate_branch.balance.plate, LADDER[0])
    own = small.resized(x)
    for point in (plate_branch.points[0], plate_branch.points[-1]):
        if abs(point.p - math.log(omega)) < 1e-9:
            gap = np.linalg.norm(small.resized(point.x) - own)
            if gap < 1e-3 * max(float(np.linalg.norm(own)), 1e-12):
                return True
    return False


def _followed(
    plate: Plate, omega: float, x: Array, low: float, high: float, harmonics: int | None
) -> PlateBranch:
    plate_branch = None
    for count in LADDER if harmonics is None else (harmonics,):
        balance = CoupledBalance(plate, count)
        start = newton.solve(balance, balance.resized(x), math.log(omega))
        if start is None:
            continue
        plate_branch = _both_ways(balance, start, omega, low, high)
        if max(balance.tail(point.x) for point in plate_branch.points) < TAIL:
            break
        if all(end.early and end.stop is not Stop.HARMONICS for end in plate_branch.ends):
            break
    if plate_branch is None:
        blank = Point(x, math.log(omega), np.zeros(len(x) + 1), 1.0)
        return PlateBranch(CoupledBalance(plate, LADDER[1]), [blank], (Ending(Stop.START),) * 2)
    return plate_branch


def _both_ways(
    balance: CoupledBalance, x: Array, omega: float, low: float, high: float
) -> PlateBranch:
    bounds = math.log(low), math.log(high)
    path = continuation.both_ways(
        balance, x, math.log(omega), *bounds, lambda point: _stop_check(balance, point), STEPS
    )
    points = [replace(q, p=min(max(q.p, bounds[0]), bounds[1])) for q in path.points]
    return PlateBranch(balance, points, path.ends)


def _stop_check(balance: CoupledBalance, point: Point) -> Ending | None:
    own = point.x.reshape(COORDINATES, -1) @ balance.basis.to_time.T
    if float((own[3:] ** 2).sum(axis=0).max()) > FURTHEST_TILT**2:
        return Ending(Stop.TILT)
    if balance.tail(point.x) > LOOSE:
        return Ending(Stop.HARMONICS, f'{balance.harmonics} harmonics do not suffice')
    return None
