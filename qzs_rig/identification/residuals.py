"""Measured minus modelled, in standard deviations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import InputError
from qzs_rig.identification.least_squares import Trial
from qzs_rig.identification.plant import Complex, plant
from qzs_rig.identification.points import Points
from qzs_rig.identification.response import Response, followed, sensitivity
from qzs_rig.identification.unknowns import Unknowns
from qzs_rig.timehistory import Array

LEAST_NOISE = 1e-5
"""Standard deviation below which no measurement is believed, relative or in rad: the balance
itself is no better."""

State = tuple[Response, ...]


@dataclass(frozen=True)
class Set:
    """The points of one degree of freedom as the fit counts them.

    `why` (n,) says why a point does not count, nothing where it does; `lag` (n,) is u/v as swept over settled, `noise` the standard
    deviation of ln T and of the phase where the points bring none of their own.
    """

    points: Points
    why: NDArray[np.str_]
    lag: Complex
    noise: tuple[float, float]

    def residual(self, ratio: Complex, slope: Complex) -> tuple[Array, Array]:
        """Residuals (2n,) of magnitude, then of phase, and their slopes (2n, p), given u/v (n,)
        settled and its logarithmic slope (n, p)."""
        points, shown = self.points, ratio * self.lag
        T, size = points.magnitude, np.abs(shown)
        turn = np.angle(np.exp(1j * np.nan_to_num(points.phase)) / shown)
        if points.weighted:
            r = np.concatenate([(T - size) / points.std, T * turn / points.std])
            weight = np.concatenate([size / points.std, T / points.std])
        else:
            # what the first order of the lag leaves out is about its square
            per = [1.0 / np.hypot(s, np.abs(self.lag - 1.0) ** 2) for s in self.noise]
            r = np.concatenate([np.log(T / size) * per[0], turn * per[1]])
            weight = np.concatenate(per)
        return r, -weight[:, None] * np.concatenate([slope.real, slope.imag])

    @property
    def use(self) -> NDArray[np.bool_]:
        """Which points (n,) count."""
        return np.asarray(self.why == '')

    @property
    def counted(self) -> NDArray[np.bool_]:
        """Which of the residuals (2n,) there are and count."""
        return np.concatenate([self.use, self.use & self.points.phased])


def evaluate(
    unknowns: Unknowns, sets: Sequence[Set], values: Array, state: State
) -> Trial[State]:
    """Residuals and slopes of all sets at `values` (p,), the motions followed from `state`.

    Nothing is good where no platform can be built of the values."""
    responses, parts = [], []
    for item, before in zip(sets, state, strict=True):
        hz, dof = item.points.frequency_hz, item.points.dof
        try:
            there = followed(plant(unknowns.applied(values), dof), hz, before.x)
            slope = sensitivity(unknowns, values, dof, there, hz)
        except InputError:
            return _nowhere(sets, values, state)
        good = there.good & before.good
        # what is lost keeps its last motion, so that it harms nothing
        x = np.where(good[:, None], there.x, before.x)
        ratio = np.where(good, there.ratio, before.ratio)
        there = Response(there.plant, there.omega, x, ratio, good)
        r, jacobian = item.residual(ratio, slope)
        parts.append((r, jacobian, item.counted & np.tile(good, 2)))
        responses.append(there)
    r, jacobian, good = (np.concatenate(column) for column in zip(*parts, strict=True))
    usable = good & np.isfinite(r) & np.isfinite(jacobian).all(axis=1)
    return Trial(values, r, jacobian, usable, tuple(responses))


def _nowhere(sets: Sequence[Set], values: Array, state: State) -> Trial[State]:
    n = 2 * sum(len(item.points) for item in sets)
    return Trial(values, np.zeros(n), np.zeros((n, len(values))), np.zeros(n, dtype=bool), state)


def noise_of(trial: Trial[State], sets: Sequence[Set]) -> list[tuple[float, float]]:
    """Standard deviations of ln T and phase of each set, by its residuals in `trial`."""
    parameters = len(trial.values)
    spent = 1.0 - parameters / max(np.count_nonzero(trial.good), parameters + 1)
    found, at = [], 0
    for item in sets:
        pair = []
        for sigma in item.noise:
            part = slice(at, at + len(item.points))
            r = trial.residual[part][trial.good[part]] * sigma
            pair.append(max(_spread(r, item.points) / spent**0.5, LEAST_NOISE))
            at += len(item.points)
        found.append((pair[0], pair[1]))
    return found


def _spread(r: Array, points: Points) -> float:
    """Root mean square; of a sweep by the median, which the free vibration of its start and its
    jumps does not widen. Settled points may differ in noise without being wrong."""
    if not r.size:
        return 1.0
    if points.chirp.any():
        return float(1.4826 * np.median(np.abs(r)))
    return float(np.sqrt(np.mean(r**2)))
