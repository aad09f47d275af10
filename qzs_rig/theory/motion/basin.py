"""Basins of attraction: which motion every start leads to, and how little it takes to change it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from qzs_rig.samples import Array
from qzs_rig.theory.motion.accuracy import cheapest_steps
from qzs_rig.theory.motion.batch import Batch
from qzs_rig.theory.motion.stroboscope import Stroboscope, strobe
from qzs_rig.theory.oscillator import Oscillator

SAME = 1e-4
"""Figures of one motion agree to this, relative to its size; they are sums over settled cycles."""

LOST, UNSETTLED = -1, -2


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
