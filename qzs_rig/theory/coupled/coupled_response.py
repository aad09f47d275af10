"""The frequency response of the coupled platform, in the form of that of one degree of freedom.

A vertically driven plate stays on its axis, where the law `geometric` is exact: its branches are
those of one degree of freedom, and only their stability is the coupled platform's own (the other
coordinates may be excited parametrically). Otherwise all six are balanced, from the motions that
single degrees of freedom suggest at both ends of the range; isolated branches are not looked for.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np

from qzs_rig.mechanics.geometric.geometry import Geometry
from qzs_rig.mechanics.platform import coupled
from qzs_rig.parameters import RunSpec
from qzs_rig.theory.balance import events as read_off
from qzs_rig.theory.balance.basis import harmonics_of, resized
from qzs_rig.theory.balance.harmonic_balance import BalanceEquations
from qzs_rig.theory.balance.newton import Point
from qzs_rig.theory.balance.one_thread import one_thread
from qzs_rig.theory.balance.response import (
    Branch,
    Event,
    FrequencyResponse,
    Progress,
    frequency_response,
    peak_among,
)
from qzs_rig.theory.coupled import plate_stability
from qzs_rig.theory.coupled.plate import COORDINATES, CoupledBalance, Plate
from qzs_rig.theory.coupled.plate_branch import PlateBranch, plate_branches
from qzs_rig.theory.coupled.plate_stability import PlateMotion, PlateStretch, multipliers
from qzs_rig.theory.oscillator import Oscillator


def response_of(
    spec: RunSpec,
    oscillator: Oscillator,
    low: float,
    high: float,
    *,
    harmonics: int | None = None,
    isolas: bool = True,
    progress: Progress | None = None,
) -> FrequencyResponse:
    """Of the platform of `spec`, which `oscillator` is of: of all six degrees of freedom where they
    move together, else of the one."""
    if coupled(spec):
        geometry = Geometry.from_spec(spec)
        return coupled_response(
            geometry, oscillator, low, high, harmonics=harmonics, progress=progress
        )
    return frequency_response(
        oscillator, low, high, harmonics=harmonics, isolas=isolas, progress=progress
    )


@one_thread
def coupled_response(
    geometry: Geometry,
    oscillator: Oscillator,
    low: float,
    high: float,
    *,
    harmonics: int | None = None,
    progress: Progress | None = None,
) -> FrequencyResponse:
    """Of the coupled platform driven along the degree of freedom, and by the base amplitude, of
    `oscillator`, its own projection.

    Events: 'fold', and where stability is lost otherwise 'period_doubling' (a multiplier at -1),
    'symmetry_breaking' (at 1) or 'neimark_sacker' (a pair on the unit circle).
    """
    own = Plate(geometry, oscillator.dof, oscillator.amplitude, oscillator.falloff)
    tell = progress or (lambda share, text: None)
    alone = frequency_response(
        oscillator,
        low,
        high,
        harmonics=harmonics,
        progress=lambda share, text: tell(0.2 * share, text),
    )
    if oscillator.dof == 'vertical':
        return _on_its_axis(alone, own, tell)
    found = plate_branches(own, alone, harmonics)
    branches, events, onsets = [], [], []
    for number, plate_branch in enumerate(found):
        branch, pairs = _branch(plate_branch, low, high, partial(_tell, tell, number, len(found)))
        branches.append(branch)
        events += _events(branch, pairs, number)
        onsets += [
            at.omega
            for k in read_off.falls(branch.omega, branch.T, branch.stable)
            if (at := plate_stability.onset(pairs[k], number)) is not None
        ]
    early = {str(end) for plate_branch in found for end in plate_branch.ends if end.early}
    return FrequencyResponse(
        oscillator,
        low,
        high,
        tuple(branches),
        tuple(events),
        tuple(sorted(onsets)),
        '; '.join(sorted(early)) or (None if found else 'no steady motion was found'),
        peak_among(branches),
    )


def _tell(tell: Progress, number: int, count: int, share: float) -> None:
    tell(0.2 + 0.8 * (number + share) / count, 'stability of six degrees of freedom')


def _on_its_axis(alone: FrequencyResponse, own: Plate, tell: Progress) -> FrequencyResponse:
    branches, events = [], []
    for number, branch in enumerate(alone.branches):
        points = [
            Point(x, math.log(w), np.zeros(len(x) + 1), float(np.linalg.norm(x)))
            for w, x in zip(branch.omega.tolist(), branch.coefficients, strict=True)
        ]
        found = []
        for k, point in enumerate(points):
            x = resized(point.x, int(branch.harmonics[k]))
            at = _axial(own, replace(point, x=x))
            found.append(multipliers(at.balance, at.x, at.omega))
            _tell(tell, number, len(alone.branches), k / len(points))
        judged = _judged(branch, np.array(found))
        pairs = [
            _axial_pair(own, alone.oscillator, branch, points, k) for k in range(len(points) - 1)
        ]
        branches.append(judged)
        events += [e for e in alone.events if e.kind == 'fold' and e.branch == number]
        events += _events(judged, pairs, number, folds=False)
    onset = tuple(w for w in alone.onset_omega if any(_is_stable(b, w) for b in branches))
    return replace(
        alone,
        branches=tuple(branches),
        events=tuple(events),
        onset_omega=onset,
        peak=peak_among(branches),
    )


def _judged(branch: Branch, found: np.ndarray[tuple[int, int], np.dtype[np.complex128]]) -> Branch:
    return replace(branch, multipliers=found, stable=np.abs(found).max(axis=1) < 1.0)


def _axial_pair(
    own: Plate, oscillator: Oscillator, branch: Branch, points: list[Point], k: int
) -> PlateStretch:
    harmonics = int(branch.harmonics[k : k + 2].max())
    here, ahead = (
        replace(q, x=resized(q.x, harmonics), tangent=np.zeros(2 * harmonics + 2))
        for q in points[k : k + 2]
    )
    return PlateStretch(BalanceEquations(oscillator, harmonics), here, ahead, partial(_axial, own))


def _axial(own: Plate, point: Point) -> PlateMotion:
    """A plate that moves by w = point.x (2H + 1,), downward, against its base."""
    omega, order = math.exp(point.p), (np.arange(len(point.x)) + 1) // 2
    x = np.zeros((COORDINATES, len(point.x)))
    # an oscillator's base moves as cos, downward, the plate's upward: half a period apart
    x[2] = -point.x * np.where(order % 2 == 0, 1.0, -1.0)
    x[2, 0] += own.scaled.height
    x[2, 1] += own.base(omega)
    return PlateMotion(CoupledBalance(own, harmonics_of(point.x)), x.ravel(), omega)


def _branch(
    plate_branch: PlateBranch, low: float, high: float, tell: Callable[[float], None]
) -> tuple[Branch, list[PlateStretch]]:
    balance, points = plate_branch.balance, plate_branch.points
    omega = np.clip(np.exp([q.p for q in points]), low, high)
    top = np.array([balance.seen(q.x) for q in points])
    base = np.array([balance.plate.base(float(w)) for w in omega])
    u = top[:, 1] - 1j * top[:, 2]
    found = []
    for k, point in enumerate(points):
        found.append(multipliers(balance, point.x, float(omega[k])))
        tell(k / len(points))
    relative = np.array(top)
    relative[:, 1] -= base
    phase = np.degrees(np.angle(u))
    branch = Branch(
        omega=omega,
        T=np.abs(u) / base,
        amplitude=np.hypot(relative[:, 1], relative[:, 2]),
        phase_deg=np.where(phase > -180.0, phase, 180.0),
        stable=np.ones(len(points), dtype=np.bool_),
        coefficients=relative,
        harmonics=np.full(len(points), balance.harmonics),
        multipliers=np.array(found),
        symmetric=False,
        ends=plate_branch.ends,
    )

    def whole(point: Point) -> PlateMotion:
        return PlateMotion(balance, point.x, math.exp(point.p))

    pairs = [PlateStretch(balance, a, b, whole) for a, b in pairwise(points)]
    return _judged(branch, np.array(found)), pairs


def _events(
    branch: Branch, pairs: list[PlateStretch], number: int, folds: bool = True
) -> list[Event]:
    found: list[tuple[int, Event]] = []
    if folds:
        found += read_off.folds(branch.omega, lambda k: plate_stability.fold(pairs[k], number))
    near = {int(k) + side for k in read_off.turns(branch.omega) for side in (-1, 0)}
    for k in np.flatnonzero(branch.stable[:-1] != branch.stable[1:]):
        located = None if int(k) in near else plate_stability.loss(pairs[k], number)
        if located is not None:
            found.append((int(k), located))
    return [event for _, event in sorted(found, key=lambda pair: pair[0])]


def _is_stable(branch: Branch, omega: float) -> bool:
    """Is there a stable stretch of the branch with T about 1 at `omega`?"""
    a, b = branch.omega[:-1], branch.omega[1:]
    here = (np.minimum(a, b) <= omega) & (omega <= np.maximum(a, b))
    crosses = (branch.T[:-1] - 1.0) * (branch.T[1:] - 1.0) <= 0
    return bool(np.any(here & crosses & branch.stable[:-1] & branch.stable[1:]))
