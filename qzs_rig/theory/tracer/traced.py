"""A whole frequency response of one oscillator, stability included, by compiled kernels."""

from __future__ import annotations

import os
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import InputError
from qzs_rig.samples import Array
from qzs_rig.theory.balance.harmonic_balance import HarmonicBalance
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.theory.tracer import curve_kernel, following, sampled
from qzs_rig.theory.tracer.balancing import Motion, Scratch
from qzs_rig.theory.tracer.curve_kernel import Kernels, Waves
from qzs_rig.theory.tracer.following import Walk

REASONS = {
    following.AT_LOW: 'reached the low end of the band',
    following.AT_HIGH: 'reached the high end of the band',
    following.CLOSED: 'came back to where it began',
    following.UNSTARTED: 'no periodic motion was found to begin with',
    following.OFF: 'left the domain of the law',
    following.STUCK: 'no next point was found',
    following.FULL: 'ran out of points',
}
"""What `Traced.reason` may be."""


@dataclass(frozen=True)
class Traced:
    """Periodic motions along one branch, as HarmonicBalance writes them: `coefficients`
    (n, 2H + 1) at `omega` (n,), which turns back at folds.

    `traces` and `determinants` (n,) are those of the monodromy matrix over one period of the drive.
    `reason` says why the branch ends where it does; what was reached before is kept.
    """

    omega: Array
    coefficients: Array
    traces: Array
    determinants: Array
    reason: str

    @property
    def stable(self) -> NDArray[np.bool_]:
        """(n,): where every small disturbance dies out, or with ζ = 0 does not grow."""
        return np.asarray(np.abs(self.traces) < 1.0 + self.determinants)

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """Floquet's, (n, 2)."""
        half = 0.5 * self.traces.astype(np.complex128)
        root = np.sqrt(half * half - self.determinants)
        return np.stack([half + root, half - root], axis=-1)


def trace(
    oscillator: Oscillator,
    low: float,
    high: float,
    *,
    harmonics: int = 7,
    direction: str = 'down',
    start: Array | None = None,
    omega: float | None = None,
    step: float = 0.1,
    miss: float = 1e-3,
    points: int = 2000,
    kernel: str = 'auto',
) -> Traced:
    """One branch over Ω in [low, high], through its folds until it leaves the band or closes.

    It begins at `omega`, by default the high end where `direction` is 'down' and the low end where
    it is 'up', with the motion near the coefficients `start` (2H + 1,) of any H. Without them,
    'down' begins from w = -v, which mass controls, and 'up', or where Newton finds nothing, from
    the motion that the oscillator settles to.

    `step` is the longest step and `miss` the predictor's error, relative to Ω and the amplitude:
    smaller ones give more points. `kernel`: 'numba', 'python' (the same figures, some hundred
    times slower), or 'auto'. Raises InputError for values without meaning.
    """
    _check(oscillator, low, high, harmonics, direction, kernel)
    kernels = _kernels(kernel)
    of = curve_kernel.waves(harmonics, HarmonicBalance(oscillator, harmonics).samples)
    own = _Own(
        (sampled.in_interpreter if kernels.lists else sampled.in_numba)(
            oscillator.law, oscillator.number
        ),
        curve_kernel.motion(oscillator),
        curve_kernel.scratch(harmonics, of, kernels.lists),
    )
    up = direction == 'up'
    begin = (low if up else high) if omega is None else omega
    if not low <= begin <= high:
        raise InputError(f'omega is {begin:g}; give one within the band {low:g} to {high:g}')
    walk = Walk(
        begin=float(begin),
        low=float(low),
        high=float(high),
        sense=1.0 if up else -1.0,
        step=step,
        miss=miss,
        settling=up and start is None,
        # harmonics tell how many samples a cubic needs
        finest=0 if oscillator.law.cubic_only else of.finest,
    )
    guess = np.zeros(2 * harmonics + 2)
    if start is not None:
        size = min(len(start), 2 * harmonics + 1)
        guess[:size] = start[:size]
    elif not up:
        guess[1:3] = _inertial(oscillator, begin)
    return _traced(oscillator, kernels, own, walk, of, guess, points)


def trace_many(
    oscillators: Iterable[Oscillator], low: float, high: float, **settings: Any
) -> list[Traced]:
    """`trace` of each, by as many threads as there are cores: the kernels let go of the GIL."""
    one = partial(trace, low=low, high=high, **settings)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(one, oscillators))


@dataclass(frozen=True)
class _Own:
    sample: Any
    motion: Motion
    scratch: Scratch


def _traced(
    oscillator: Oscillator,
    kernels: Kernels,
    own: _Own,
    walk: Walk,
    of: Waves,
    guess: Array,
    points: int,
) -> Traced:
    room: list[Any] = [guess, np.empty((points, len(guess))), np.empty(points)]
    if kernels.lists:
        room = [each.tolist() for each in room]
    y, path, line = room
    with np.errstate(all='ignore'):
        count, why = kernels.follow(
            own.sample,
            kernels.settle,
            kernels.correct,
            own.motion,
            own.scratch,
            walk,
            y,
            path,
            line,
        )
        kernels.monodromies(own.sample, own.motion, own.scratch, of.finest, path, count, line)
    found = np.array(path[:count], dtype=np.float64).reshape(count, len(guess))
    omega = found[:, -1]
    return Traced(
        omega,
        found[:, :-1],
        np.array(line[:count], dtype=np.float64),
        np.exp(-4.0 * np.pi * oscillator.zeta / omega),
        REASONS[why],
    )


def _kernels(kernel: str) -> Kernels:
    if kernel != 'python':
        try:
            return curve_kernel.in_numba()
        except ImportError:
            if kernel == 'numba':
                raise InputError(
                    "kernel = 'numba' needs numba; pip install 'qzs_rig[fast]' or leave it at auto"
                ) from None
    return curve_kernel.in_interpreter()


def _inertial(oscillator: Oscillator, omega: float) -> tuple[float, float]:
    """cos and sin of w'' + 2 ζ w' = drive: what remains where the springs are soft."""
    square, damping = omega * omega, 2.0 * oscillator.zeta * omega
    share = oscillator.drive(omega) / (square * square + damping * damping)
    return -share * square, share * damping


def _check(
    oscillator: Oscillator, low: float, high: float, harmonics: int, direction: str, kernel: str
) -> None:
    if not 0.0 < low < high < np.inf:
        raise InputError(f'the band is {low:g} to {high:g}; give one that rises from above 0')
    if not oscillator.amplitude > 0.0:
        raise InputError('amplitude is 0: nothing moves; give a small one, 1e-6, instead')
    if harmonics < 1:
        raise InputError(f'harmonics is {harmonics}; give 1 or more')
    for name, value, known in (
        ('direction', direction, ('down', 'up')),
        ('kernel', kernel, ('auto', 'numba', 'python')),
    ):
        if value not in known:
            raise InputError(f'{name} is {value!r}; give one of {", ".join(known)}')
