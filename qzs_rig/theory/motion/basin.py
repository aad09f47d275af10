"""Basins of attraction: which motion every start leads to, and how far a motion is from a jump: the
smallest kick, and the smallest rise of the level."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from qzs_rig.errors import InputError
from qzs_rig.samples import Array
from qzs_rig.theory.motion.batch import Batch
from qzs_rig.theory.motion.stroboscope import Stroboscope, cheapest_steps, history, strobe
from qzs_rig.theory.oscillator import Oscillator

SAME = 1e-4
"""Figures of one motion agree to this, relative to its size; they are sums over settled cycles."""

LOST, UNSETTLED = -1, -2
PHASES = 8
"""Moments of the period at which a kick is tried."""
TRIES = 64
"""Sizes that are tried at once; twice, the second time between stay and jump."""


@dataclass(frozen=True)
class Attractor:
    """A motion that runs settle into: `period` times the base's, its fundamental's `T` and
    `phase_deg` against the base, extremes of w, and the state `w`, `velocity` of one such run."""

    period: int
    T: float
    phase_deg: float
    low: float
    high: float
    w: float
    velocity: float
    share: float


@dataclass(frozen=True)
class Basin:
    """`which` (n_velocity, n_w): index into `attractors`, most frequent first, for every start
    (`w`, `velocity`); LOST where the run left its law, UNSETTLED where it found no cycle."""

    omega: float
    w: Array
    velocity: Array
    which: NDArray[np.int64]
    attractors: tuple[Attractor, ...]
    steps: int
    periods: int


def basin(
    oscillator: Oscillator,
    omega: float,
    w: ArrayLike,
    velocity: ArrayLike,
    *,
    periods: int = 1000,
    phase: float = 0.0,
    error: float = 1e-5,
    workers: int | None = None,
) -> Basin:
    """Runs from every pair of `w` and `velocity` where the base's phase is `phase`."""
    across = np.atleast_1d(np.asarray(w, dtype=np.float64))
    along = np.atleast_1d(np.asarray(velocity, dtype=np.float64))
    grid = np.meshgrid(across, along)
    runs = Batch.of(oscillator, omega, w=grid[0].ravel(), velocity=grid[1].ravel())
    steps = cheapest_steps(runs, error)
    seen = strobe(runs, steps=steps, periods=periods, keep=0, phase=phase, workers=workers)
    which, found = attractors(seen)
    return Basin(omega, across, along, which.reshape(grid[0].shape), found, steps, periods)


def attractors(seen: Stroboscope) -> tuple[NDArray[np.int64], tuple[Attractor, ...]]:
    """Which motion each run found (n,), and these motions, most frequent first."""
    marks = features(seen)
    which = np.where(seen.period < 0, LOST, UNSETTLED)
    left, found = np.flatnonzero(seen.period > 0), 0
    while left.size:
        first = left[0]
        size = max(1e-3, float(np.abs(marks[first, 1:]).max()))
        alike = np.all(np.abs(marks[left] - marks[first]) <= SAME * size, axis=1)
        which[left[alike]] = found
        left, found = left[~alike], found + 1
    counts = np.bincount(which[which >= 0], minlength=found)
    order = np.argsort(-counts, kind='stable')
    rank = np.empty(found, dtype=np.int64)
    rank[order] = np.arange(found)
    which[which >= 0] = rank[which[which >= 0]]
    return which, tuple(_attractor(seen, which == k) for k in range(found))


def features(seen: Stroboscope) -> Array:
    """(n, 5) period, fundamental and extremes: the same for all runs of one motion, whichever
    period of a longer cycle they are in."""
    wave = seen.fundamental
    return np.stack([seen.period, wave.real, wave.imag, seen.low, seen.high], axis=-1)


def _attractor(seen: Stroboscope, mine: NDArray[np.bool_]) -> Attractor:
    k = int(np.flatnonzero(mine)[0])
    ratio = complex(seen.transmissibility[k])
    return Attractor(
        period=int(seen.period[k]),
        T=abs(ratio),
        phase_deg=float(np.degrees(np.angle(ratio))),
        low=float(seen.low[k]),
        high=float(seen.high[k]),
        w=float(seen.end[k, 0]),
        velocity=float(seen.end[k, 1]),
        share=float(mine.mean()),
    )


@dataclass(frozen=True)
class JumpMargin:
    """At one frequency, for the motion `now` that a run from rest settles into: `kick` is the
    smallest sudden change of dw/dτ, either way and at the worst of eight phases, after which it
    settles into `other`; `rise` the smallest factor by which the level must go up, until settled,
    so that it does not come back when the level does. NaN where none up to the largest tried does.
    """

    omega: float
    now: Attractor
    other: Attractor | None
    kick: float
    kick_phase_deg: float
    rise: float


def jump_margin(
    oscillator: Oscillator,
    omega: float,
    *,
    largest_kick: float,
    largest_rise: float = 4.0,
    least: float = 0.05,
    periods: int = 1000,
    error: float = 1e-5,
) -> JumpMargin:
    """Try kicks up to `largest_kick` and levels up to `largest_rise` times the level.

    A motion counts as another where its T differs by more than the share `least`: laws that are not
    odd, and odd ones by their mirror images, have pairs of motions that differ much less. Good to a
    thousandth of the largest; a jump that only a band of smaller kicks sets off may be
    missed. Raises InputError where the run from rest does not settle.
    """
    if not (largest_kick > 0.0 and largest_rise > 1.0):
        raise InputError('a jump margin needs a largest kick above 0 and a largest rise above 1')
    rest = Batch.of(oscillator, omega)
    steps = PHASES * math.ceil(cheapest_steps(rest, error) / PHASES)
    seen = strobe(rest, steps=steps, periods=periods, keep=0)
    if seen.period[0] < 1:
        raise InputError(
            f'the run from rest at omega {omega:g} does not settle within {periods} periods: '
            'there is no motion to jump from; raise the periods, or see the basin'
        )
    trial = _Trial(rest, steps, periods, seen, least)
    kick, phase, landed = math.nan, math.nan, None
    for k, (w, velocity) in enumerate(trial.states()):
        bound = largest_kick if math.isnan(kick) else kick
        found, there = trial.smallest_kick(w, velocity, 2.0 * math.pi * k / PHASES, bound)
        if found < bound or (math.isnan(kick) and found <= bound):
            kick, phase, landed = found, 360.0 * k / PHASES, there
    rise = trial.smallest_rise(largest_rise)
    return JumpMargin(omega, attractors(seen)[1][0], landed, kick, phase, rise)


class _Trial:
    """The motion at one frequency, and what it does when disturbed."""

    def __init__(
        self, rest: Batch, steps: int, periods: int, seen: Stroboscope, least: float
    ) -> None:
        self._rest, self._steps, self._periods = rest, steps, periods
        self._seen, self._least = seen, least
        self._w, self._velocity = (float(x) for x in seen.end[0])

    def states(self) -> Array:
        """(8, 2) of the settled motion, over one period of the base."""
        run = history(self._rest.starting(self._w, self._velocity), 1, self._steps)
        every = slice(0, self._steps, self._steps // PHASES)
        return np.stack([run.w[every], run.velocity[every]], axis=-1)

    def smallest_kick(
        self, w: float, velocity: float, phase: float, bound: float
    ) -> tuple[float, Attractor | None]:
        """Smallest kick up to `bound` at a state, and where it leads."""
        low, best, there = 0.0, math.nan, None
        for _ in range(2):
            high = bound if math.isnan(best) else best
            sizes = np.linspace(low, high, TRIES // 2 + 1)[1:]
            kicks = np.concatenate([sizes, -sizes])
            seen = self._run(self._rest[np.zeros(TRIES, int)], w, velocity + kicks, phase)
            jumped = self._elsewhere(seen)
            if not jumped.any():
                break
            best = float(np.abs(kicks[jumped]).min())
            first = jumped & (np.abs(kicks) == best)
            there = attractors(seen[first])[1][0]
            low = max(0.0, best - bound / (TRIES // 2))
        return best, there

    def smallest_rise(self, largest: float) -> float:
        """Smallest factor on the level that leaves the motion elsewhere once it is taken back."""
        low, best = 1.0, math.nan
        for _ in range(2):
            factors = np.linspace(low, largest if math.isnan(best) else best, TRIES + 1)[1:]
            runs = self._rest[np.zeros(TRIES, int)]
            raised = replace(runs, amplitude=runs.amplitude * factors)
            up = self._run(raised, self._w, self._velocity, 0.0)
            back = self._run(runs, up.end[:, 0], up.end[:, 1], 0.0)
            jumped = self._elsewhere(back)
            if not jumped.any():
                break
            best = float(factors[jumped].min())
            low = max(1.0, best - (largest - 1.0) / TRIES)
        return best

    def _run(self, runs: Batch, w: object, velocity: object, phase: float) -> Stroboscope:
        started = runs.starting(np.asarray(w), np.asarray(velocity))
        return strobe(started, steps=self._steps, periods=self._periods, keep=0, phase=phase)

    def _elsewhere(self, seen: Stroboscope) -> NDArray[np.bool_]:
        change = np.abs(seen.transmissibility) / abs(self._seen.transmissibility[0])
        return np.asarray((np.abs(change - 1.0) > self._least) & (seen.period > 0))
