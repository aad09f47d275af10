"""Motions from which branches are followed: enough of them to find the isolated ones."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from qzs_rig.samples import Array
from qzs_rig.theory.balance.basis import harmonics_of, resized
from qzs_rig.theory.balance.describing import Describing, describing, motions
from qzs_rig.theory.balance.follow import Followed, Task
from qzs_rig.theory.balance.harmonic_balance import steady
from qzs_rig.theory.balance.symmetry import mirrored, symmetric
from qzs_rig.theory.oscillator import Oscillator

HARMONICS = 9
"""Of the first search at each frequency."""
KICKS = 12
"""Random disturbances of each known motion, to fall onto unknown ones."""


def one_term(
    oscillator: Oscillator, omega: Array, table: Describing | None = None
) -> Iterator[tuple[float, Array]]:
    """Motions (2H + 1,) at each of `omega` that the one-harmonic ones lead to."""
    table = table or describing(oscillator)
    starts = [motions(oscillator, table, float(w)) for w in omega]
    counts = [len(start) for start in starts]
    if sum(counts):
        yield from _converged(
            oscillator, np.repeat(omega, counts), resized(np.concatenate(starts), HARMONICS)
        )


def kicked(
    oscillator: Oscillator, omega: Array, known: Sequence[Followed], seed: int
) -> Iterator[tuple[float, Array]]:
    """Motions at each of `omega` that random disturbances of the `known` ones lead to."""
    rng = np.random.default_rng(seed)
    fading = 0.6 ** np.repeat(np.arange(HARMONICS + 1), 2)[1:]
    places, starts = [], []
    for w in omega:
        for path in known:
            for x in crossings(path, float(w)):
                size = np.linalg.norm(x)
                kick = rng.normal(size=(KICKS, 2 * HARMONICS + 1)) * fading
                starts.append(resized(x, HARMONICS) + 0.4 * size * kick)
                places += [float(w)] * KICKS
    if starts:
        yield from _converged(oscillator, np.array(places), np.concatenate(starts))


def crossings(path: Followed, omega: float) -> list[Array]:
    """Motions (2H + 1,) of a path where it passes `omega`, between its points."""
    here, ahead = path.omega[:-1], path.omega[1:]
    found = []
    # the end of a range comes back from its logarithm a bit off
    for k in np.flatnonzero(
        (np.minimum(here, ahead) <= omega * (1 + 1e-12))
        & (omega * (1 - 1e-12) <= np.maximum(here, ahead))
    ):
        gap = ahead[k] - here[k]
        share = (omega - here[k]) / gap if gap else 0.0
        x = path.coefficients
        found.append(x[k] + share * (x[k + 1] - x[k]))
    return found


def is_known(task: Task, known: Sequence[Followed]) -> bool:
    """Does one of the paths pass the motion of `task`, or its mirror image?"""
    for path in known:
        for guess in crossings(path, task.omega):
            for x in (
                (task.coefficients, mirrored(task.coefficients))
                if symmetric(task.oscillator)
                else (task.coefficients,)
            ):
                if _same_motion(task, guess, x):
                    return True
    return False


def _same_motion(task: Task, guess: Array, x: Array) -> bool:
    most = max(harmonics_of(guess), harmonics_of(x))
    guess, x = resized(guess, most), resized(x, most)
    size = float(np.linalg.norm(x)) or 1.0
    if np.linalg.norm(guess - x) > 0.1 * size:
        return False
    here = np.array([task.omega])
    near = steady(task.oscillator, here, guess[None], 0.01 * _small(task.oscillator, here))
    if not near.converged[0]:
        return bool(np.linalg.norm(guess - x) < 0.02 * size)
    return bool(np.linalg.norm(near.coefficients[0] - x) < 1e-5 * size)


def _small(oscillator: Oscillator, omega: Array) -> float:
    """A residual that is small against the drive, and above rounding."""
    return float(max(1e-8 * np.min(oscillator.drive(omega)), 1e-14))


def _converged(
    oscillator: Oscillator, omega: Array, starts: Array
) -> Iterator[tuple[float, Array]]:
    found = steady(oscillator, omega, starts, _small(oscillator, omega), 25)
    kept: list[tuple[float, Array]] = []
    for w, x, good in zip(found.omega, found.coefficients, found.converged, strict=True):
        if not good or any(
            w == other and np.linalg.norm(x - y) < 1e-5 * np.linalg.norm(x) for other, y in kept
        ):
            continue
        kept.append((float(w), x))
    yield from kept
