"""The frequency response of the coupled platform, in the form of that of one degree of freedom.

A vertically driven plate stays on its axis, where the law `geometric` is exact: its branches are
those of one degree of freedom, and only their stability is the coupled platform's own (the other
coordinates may be excited parametrically). Otherwise all six are balanced, from the motions that
single degrees of freedom suggest at both ends of the range; isolated branches are not looked for.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from qzs_rig.mechanics.geometry import Geometry
from qzs_rig.mechanics.platform import coupled
from qzs_rig.parameters import RunSpec
from qzs_rig.samples import Array
from qzs_rig.theory.balance import newton, search
from qzs_rig.theory.balance.basis import Basis, resized
from qzs_rig.theory.balance.bifurcations import turns
from qzs_rig.theory.balance.branch import BranchPath, BranchProblem, ends_in, follow, refined
from qzs_rig.theory.balance.continuation import Ending, Steps, Stop
from qzs_rig.theory.balance.frequency_response import (
    FrequencyResponse,
    Progress,
    check,
    frequency_response,
    read_off,
)
from qzs_rig.theory.balance.harmonic_balance import HarmonicBalance
from qzs_rig.theory.balance.newton import Point, one_thread
from qzs_rig.theory.balance.plate import COORDINATES, Plate
from qzs_rig.theory.balance.stability import Stability, changes, multipliers
from qzs_rig.theory.oscillator import Oscillator

FURTHEST_TILT = 0.5
"""Sine of half the angle, about 1 rad, beyond which arms would collide."""
STEPS_A_RADIAN = 3.0
"""Steps of a disturbance while the fastest one turns by a radian."""
SAME = 1e-3
"""Relative distance of two motions of a plate below which they are one."""


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
    check(oscillator, low, high)
    tell = progress or (lambda share, text: None)
    own = Plate(geometry, oscillator.dof, oscillator.amplitude, oscillator.falloff)
    span = search.Range(oscillator, low, high, harmonics)
    alone = search.paths(span, True, lambda share, text: tell(0.2 * share, text))
    if oscillator.dof == 'vertical':
        axial: search.Found = [
            (path, partial(AxialBalance, oscillator, odd=family(1).odd, plate=own))
            for path, family in alone
        ]
        return read_off(oscillator, low, high, axial, tell)
    found: list[BranchPath] = []
    six = partial(CoupledBalance, own)
    for omega in (high, low):
        for start in _starts(own, [path for path, _ in alone], omega):
            problem = BranchProblem(six, omega, start, low, high, harmonics)
            x = refined(problem)
            if x is not None and not any(ends_in(path, omega, x, SAME) for path in found):
                found.append(follow(problem))
    return read_off(oscillator, low, high, [(path, six) for path in found], tell)


def _starts(plate: Plate, alone: list[BranchPath], omega: float) -> Iterator[Array]:
    """Motions (6, 2H + 1) to start from: what a plate that hangs still in space leads to, and those
    in which the projected degree of freedom moves as a branch `alone` that ends at `omega` does."""
    balance = CoupledBalance(plate, CoupledBalance.ladder[1])
    still = balance.full(balance.resting())
    guesses = [still]
    for path in alone:
        for end in (0, -1):
            if path.value[end] == omega:
                top = resized(path.coefficients[end], balance.harmonics)
                top[1] += plate.base(omega)
                guesses.append(_moving(plate, still, top))
    for guess in guesses:
        x = newton.solve(balance, guess.ravel(), math.log(omega))
        if x is not None:
            yield balance.full(x)


def _moving(plate: Plate, still: Array, top: Array) -> Array:
    x = np.array(still)
    if plate.dof == 'horizontal':
        x[0] += top
    elif plate.dof == 'vertical_rotation':
        x[5] += 0.5 * top
    else:
        x[4] += 0.5 * top
        x[0] += plate.scaled.height * top
    return x


class _Judged(ABC):
    """A balance whose motions are judged by the plate's twelve multipliers."""

    by_determinant: ClassVar[bool] = False

    @abstractmethod
    def multipliers(self, coefficients: Array, omega: float) -> NDArray[np.complex128]:
        """(12,) over one period of the drive, largest first."""

    @abstractmethod
    def lead(self, point: Point) -> complex:
        """The largest of the motion at a point of a path."""

    def stability(self, values: Array, coefficients: Array) -> Stability:
        """Of motions (n, ...) at Ω = `values` (n,). A fold changes stability, too: what happens
        beside the turning points of the path is left to it."""
        pairs = zip(coefficients, values.tolist(), strict=True)
        found = np.array([self.multipliers(x, omega) for x, omega in pairs])
        stable = np.abs(found).max(axis=1) < 1.0
        beside = np.concatenate([turns(values) - 1, turns(values)])
        return Stability(found, stable, np.setdiff1d(changes(stable), beside))

    def losing(self, point: Point) -> float:
        """0 where the largest multiplier crosses the unit circle."""
        return abs(self.lead(point)) - 1.0

    def kind(self, point: Point) -> str:
        """'period_doubling' at -1, 'symmetry_breaking' at 1, 'neimark_sacker' as a pair."""
        lead = self.lead(point)
        if abs(lead.imag) < 1e-4:
            return 'period_doubling' if lead.real < 0 else 'symmetry_breaking'
        return 'neimark_sacker'


@dataclass(frozen=True)
class CoupledBalance(_Judged):
    """The balance of all six coordinates over ln Ω; see branch.Balance. Coefficients are
    (6, 2H + 1), one row a coordinate; the unknowns x are the same, flat."""

    plate: Plate
    harmonics: int

    ladder: ClassVar[tuple[int, ...]] = (5, 9, 15, 21)
    accuracy: ClassVar[float] = 1e-7
    loosest: ClassVar[float] = 1e-3
    steps: ClassVar[Steps] = Steps(first=0.02, largest=0.1, turn=0.25, most=250)
    finest: ClassVar[int] = 0
    odd: ClassVar[bool] = False
    mirrored: ClassVar[bool] = False

    @property
    def basis(self) -> Basis:
        """The waves of every coordinate."""
        return Basis.full(self.harmonics)

    @property
    def angle(self) -> Array:
        """(samples,): phases of the base at which forces are taken."""
        return 2 * np.pi * np.arange(self.basis.samples) / self.basis.samples

    def motion(self, x: Array, omega: float, angle: Array) -> tuple[Array, Array, Array]:
        """Coordinates, velocities and accelerations, each (6, n), at n phases."""
        waves = self.basis.waves(angle / (2 * np.pi))
        own = self.full(x)
        speed = omega * own @ self.basis.derivative.T
        pull = -((omega * self.basis.rates) ** 2) * own
        return own @ waves.T, speed @ waves.T, pull @ waves.T

    def residual(self, x: Array, omega: float) -> Array:
        """What the unknowns leave unbalanced, (6 (2H + 1),)."""
        found = self.plate.residual(*self.motion(x, omega, self.angle), omega, self.angle)
        return np.asarray(found @ self.basis.to_frequency.T).ravel()

    def linearised(self, x: Array, p: float) -> tuple[Array, Array, Array]:
        """See newton.Equations."""
        omega, basis = math.exp(min(p, 50.0)), self.basis
        motion = self.motion(x, omega, self.angle)
        place, speed, pull = basis.tangent(self.plate.slopes(*motion, omega, self.angle))
        blocks = place + omega * speed @ basis.derivative - pull * (omega * basis.rates) ** 2
        size = COORDINATES * len(basis.rates)
        jacobian = np.moveaxis(blocks, 2, 1).reshape(size, size)
        # only Newton's pace and the tangent hang on it
        ahead, behind = (self.residual(x, omega * math.exp(side)) for side in (1e-5, -1e-5))
        return self.residual(x, omega), jacobian, (ahead - behind) / 2e-5

    def resting(self) -> Array:
        """The unknowns of a plate at rest in space."""
        return self.own(self.plate.rest[:, None])

    def full(self, x: Array) -> Array:
        """The coefficients (6, 2H + 1) of the unknowns x."""
        return x.reshape(COORDINATES, -1)

    def own(self, coefficients: Array) -> Array:
        """The unknowns of coefficients in any number of harmonics."""
        return resized(coefficients, self.harmonics).ravel()

    def tail(self, coefficients: Array, harmonics: int) -> float:
        """What the last two of `harmonics`, and all above, are of all that moves."""
        high = float(np.linalg.norm(coefficients[:, 2 * harmonics - 3 :]))
        return high / (float(np.linalg.norm(coefficients[:, 1:])) or 1.0)

    def beyond(self, x: Array) -> Ending | None:
        """Stop.TILT where the plate of unknowns x turns so far that arms would collide, or None."""
        own = self.full(x) @ self.basis.to_time.T
        tilted = float((own[3:] ** 2).sum(axis=0).max()) > FURTHEST_TILT**2
        return Ending(Stop.TILT) if tilted else None

    def seen(self, x: Array) -> Array:
        """(2H + 1,): coefficients of the plate's own motion along the driven degree of freedom."""
        own = self.full(x) @ self.basis.to_time.T
        return np.asarray(self.basis.to_frequency @ self.plate.seen(own))

    def relative(self, values: Array, coefficients: Array) -> Array:
        """(n, 2H + 1): the same against the base, of motions (n, 6, 2H + 1) at Ω = `values`."""
        top = np.array([self.seen(x) for x in coefficients])
        top[:, 1] -= self.base(values)
        return top

    def frequency(self, values: Array) -> Array:
        """Ω (n,), which is the parameter."""
        return values

    def base(self, values: Array) -> Array:
        """Amplitude (n,) of the base at Ω = `values`."""
        return np.array([self.plate.base(omega) for omega in values.tolist()])

    def rates(self, x: Array, omega: float, angle: Array) -> Array:
        """(n, 12, 12): the linear rates of a small disturbance and its velocity, at n phases."""
        place, speed, pull = np.moveaxis(
            self.plate.slopes(*self.motion(x, omega, angle), omega, angle), -1, 1
        )
        matrix = np.zeros((len(angle), 2 * COORDINATES, 2 * COORDINATES))
        matrix[:, :COORDINATES, COORDINATES:] = np.eye(COORDINATES)
        matrix[:, COORDINATES:] = -np.linalg.solve(pull, np.concatenate([place, speed], axis=-1))
        return matrix

    def multipliers(self, coefficients: Array, omega: float) -> NDArray[np.complex128]:
        """(12,) of a motion (6, 2H + 1)."""
        x = coefficients.ravel()
        rough = self.rates(x, omega, self.angle)
        fastest = float(np.abs(np.linalg.eigvals(rough[:: max(1, len(rough) // 8)])).max())
        wanted = max(self.basis.samples, STEPS_A_RADIAN * 2 * np.pi * fastest / omega, 64)
        return multipliers(lambda angle: self.rates(x, omega, angle), omega, wanted)

    def lead(self, point: Point) -> complex:
        """The largest multiplier at a point of a path."""
        return complex(self.multipliers(self.full(point.x), math.exp(point.p))[0])

    def defect(self, values: Array, coefficients: Array) -> float:
        """0: what is left in more harmonics is not computed for six coordinates."""
        return 0.0

    def along(self, point: Point) -> tuple[complex, complex]:
        """u/v of the fundamentals, and its slope along a path, by a central difference."""

        def ratio(step: float) -> complex:
            top = self.seen(point.x + step * point.size * point.tangent[:-1])
            omega = math.exp(point.p + step * float(point.tangent[-1]))
            return complex(top[1], -top[2]) / self.plate.base(omega)

        return ratio(0.0), (ratio(1e-6) - ratio(-1e-6)) / 2e-6


@dataclass(frozen=True)
class AxialBalance(_Judged, HarmonicBalance):
    """The balance of a `plate` that moves along its axis, as one degree of freedom does; but any of
    the others may be excited parametrically, and so all six tell whether it is stable."""

    plate: Plate = field(kw_only=True)

    def multipliers(self, coefficients: Array, omega: float) -> NDArray[np.complex128]:
        """(12,) of a plate that moves by w (2H + 1,), downward, against its base."""
        harmonics = max(1, len(np.trim_zeros(coefficients, 'b')) // 2)
        order = (np.arange(2 * harmonics + 1) + 1) // 2
        x = np.zeros((COORDINATES, len(order)))
        # an oscillator's base moves as cos, downward, the plate's upward: half a period apart
        x[2] = -resized(coefficients, harmonics) * np.where(order % 2 == 0, 1.0, -1.0)
        x[2, 0] += self.plate.scaled.height
        x[2, 1] += self.plate.base(omega)
        return CoupledBalance(self.plate, harmonics).multipliers(x, omega)

    def lead(self, point: Point) -> complex:
        """The largest multiplier at a point of a path."""
        return complex(self.multipliers(self.full(point.x), math.exp(point.p))[0])
