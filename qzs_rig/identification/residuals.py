"""Measured minus modelled, in standard deviations."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import InputError
from qzs_rig.identification.least_squares import Trial
from qzs_rig.identification.points import Complex, Points
from qzs_rig.identification.response import Response, followed, sensitivity
from qzs_rig.identification.unknowns import Unknowns
from qzs_rig.samples import Array
from qzs_rig.theory.oscillator import Oscillator

LEAST_NOISE = 1e-4
"""Standard deviation below which no measurement is believed, relative or in rad: windows that have
settled still differ by that."""

State = tuple[Response, ...]


@dataclass(frozen=True)
class Set:
    """The points of one degree of freedom as the fit counts them.

    `why` (n,) says why a point does not count, nothing where it does; `lag` (n,) is u/v as swept
    over settled, `noise` the standard deviation of ln T and of the phase where the points bring
    none of their own.
    """

    points: Points
    why: NDArray[np.str_]
    lag: Complex
    noise: tuple[float, float]

    def missed(self, ratio: Complex) -> tuple[Array, Array]:
        """Residuals (2n,) of magnitude, then of phase, given u/v (n,) settled; and the weights
        (2n,) by which they fall as ln u/v grows."""
        points, shown = self.points, ratio * self.lag
        T, size = points.magnitude, np.abs(shown)
        turn = np.angle(np.exp(1j * np.nan_to_num(points.phase)) / shown)
        if points.weighted:
            r = np.concatenate([(T - size) / points.std, T * turn / points.std])
            return r, np.concatenate([size / points.std, T / points.std])
        # what the first order of the lag leaves out is about its square
        per = [1.0 / np.hypot(s, np.abs(self.lag - 1.0) ** 2) for s in self.noise]
        return np.concatenate([np.log(T / size) * per[0], turn * per[1]]), np.concatenate(per)

    def residual(self, ratio: Complex, slope: Complex) -> tuple[Array, Array]:
        """Residuals (2n,) as `missed`, and their slopes (2n, p) given that of ln u/v (n, p)."""
        r, weight = self.missed(ratio)
        return r, -weight[:, None] * np.concatenate([slope.real, slope.imag])

    @property
    def use(self) -> NDArray[np.bool_]:
        """Which points (n,) count."""
        return np.asarray(self.why == '')

    @property
    def counted(self) -> NDArray[np.bool_]:
        """Which of the residuals (2n,) there are and count."""
        return np.concatenate([self.use, self.use & self.points.phased])


def evaluate(unknowns: Unknowns, sets: Sequence[Set], values: Array, state: State) -> Trial[State]:
    """Residuals and slopes of all sets at `values` (p,), the motions followed from `state`.

    Nothing is good where no platform can be built of the values."""
    responses, parts = [], []
    for item, before in zip(sets, state, strict=True):
        hz, dof = item.points.frequency_hz, item.points.dof
        try:
            there = _kept(
                followed(Oscillator.driven(unknowns.applied(values), dof), hz, before.x), before
            )
            slope = sensitivity(unknowns, values, dof, there, hz)
        except InputError:
            return _nowhere(sets, values, state)
        good = there.good
        r, jacobian = item.residual(there.ratio, slope)
        parts.append((r, jacobian, item.counted & np.tile(good, 2)))
        responses.append(there)
    r, jacobian, good = (np.concatenate(column) for column in zip(*parts, strict=True))
    usable = good & np.isfinite(r) & np.isfinite(jacobian).all(axis=1)
    return Trial(values, r, jacobian, usable, tuple(responses))


def _kept(there: Response, before: Response) -> Response:
    """`there`, but with the motion of `before` where a point has lost its branch."""
    good = there.good & before.good
    x = np.where(good[:, None], there.x, before.x)
    ratio = np.where(good, there.ratio, before.ratio)
    return Response(there.plant, there.omega, x, ratio, good)


def _nowhere(sets: Sequence[Set], values: Array, state: State) -> Trial[State]:
    n = 2 * sum(len(item.points) for item in sets)
    return Trial(values, np.zeros(n), np.zeros((n, len(values))), np.zeros(n, dtype=bool), state)


def noise_of(
    trial: Trial[State], sets: Sequence[Set], spread: Callable[[Array], float]
) -> list[tuple[float, float]]:
    """Standard deviations of ln T and phase of each set, by its residuals in `trial`."""
    parameters = len(trial.values)
    spent = 1.0 - parameters / max(int(np.count_nonzero(trial.good)), parameters + 1)
    found, at = [], 0
    for item in sets:
        pair = []
        for sigma in item.noise:
            part = slice(at, at + len(item.points))
            r = trial.residual[part][trial.good[part]] * sigma
            level = spread(r) / spent**0.5 if r.size else 1.0
            pair.append(max(level, LEAST_NOISE))
            at += len(item.points)
        found.append((pair[0], pair[1]))
    return found


def usual(r: Array) -> float:
    """By the median, which transitions and free vibration do not widen."""
    return float(1.4826 * np.median(np.abs(r)))


def quadratic(r: Array) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(r**2)))
