"""Finding all branches of a range: from both its ends, from between, from broken symmetry, from
random disturbances of known motions.

The first motions come from one harmonic, of any law: the describing function as a table (Magnus,
Schwingungen, 1961; MODEL section 5 is its case of a cubic law). A motion m + W cos(Ωτ + φ) feels
the force <F> = 0 on average and the stiffness N(W) on its fundamental.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from qzs_rig.samples import Array
from qzs_rig.theory.balance import newton
from qzs_rig.theory.balance.basis import (
    Basis,
    harmonics_of,
    lopsided,
    mirrored,
    resized,
    symmetric,
)
from qzs_rig.theory.balance.bifurcations import Located, Stretch, locate, losing
from qzs_rig.theory.balance.branch import BranchPath, BranchProblem, Family, follow, refined
from qzs_rig.theory.balance.continuation import Stop
from qzs_rig.theory.balance.harmonic_balance import HarmonicBalance, steady
from qzs_rig.theory.balance.stability import tangent
from qzs_rig.theory.oscillator import Oscillator

BETWEEN = 24
"""Frequencies at which isolated branches are looked for."""
Found = list[tuple[BranchPath, Family]]
"""Paths with their equations."""
HARMONICS = 9
"""Of the first search at each frequency."""
KICKS = 12
"""Random disturbances of each known motion, to fall onto unknown ones."""
SAMPLES = 48
LEVELS = 240
MEANS = 61


@dataclass(frozen=True)
class Range:
    """What is looked at, and how."""

    oscillator: Oscillator
    low: float
    high: float
    harmonics: int | None
    tolerance: float = 1e-10

    @cached_property
    def odd(self) -> bool:
        """Can motions mirror themselves every half period?"""
        return symmetric(self.oscillator)

    def problem(self, omega: float, x: Array) -> BranchProblem:
        """To follow the branch of the motion x (2H + 1,) at `omega`, in odd harmonics if it has no
        others."""
        odd = self.odd and lopsided(x) < 1e-6
        family = partial(HarmonicBalance, self.oscillator, odd=odd)
        return BranchProblem(family, omega, x, self.low, self.high, self.harmonics, self.tolerance)


def paths(span: Range, isolas: bool, tell: Callable[[float, str], None]) -> Found:
    """Every path, those at the upper end of the range first."""
    found: Found = []
    table = describing(span.oscillator)
    ends = np.array([span.high, span.low])
    tell(0.0, 'branches from the ends of the range')
    _follow(span, one_term(span.oscillator, ends, table), found)
    between = np.geomspace(span.low, span.high, BETWEEN + 2)[1:-1]
    if isolas or not found:
        tell(0.3, 'isolated branches')
        _follow(span, one_term(span.oscillator, between, table), found)
    if span.odd:
        tell(0.5, 'broken symmetry')
        partings = [at for path, family in found for at in _partings(path, family)]
        _follow(span, _broken(span, partings), found)
        found = [(_joined(path, partings), family) for path, family in found]
    if isolas:
        tell(0.6, 'isolated branches')
        known = [path for path, _ in found]
        _follow(span, kicked(span.oscillator, between, known, seed=1), found)
    return found


def least_path(span: Range, omega: float) -> Found:
    """The path of the smallest motion at `omega`, if there is any."""
    guesses = sorted(
        one_term(span.oscillator, np.array([omega])), key=lambda at: np.linalg.norm(at[1])
    )
    for _, x in guesses:
        start = refined(span.problem(omega, x))
        if start is not None:
            problem = span.problem(omega, start)
            return [(follow(problem), problem.family)]
    return []


def _follow(span: Range, seeds: Iterator[tuple[float, Array]], found: Found) -> None:
    for omega, x in seeds:
        known = [path for path, _ in found]
        if is_known(span.oscillator, omega, x, known):
            continue
        start = refined(span.problem(omega, x))
        if start is not None and not is_known(span.oscillator, omega, start, known):
            problem = span.problem(omega, start)
            found.append((follow(problem), problem.family))


def _partings(path: BranchPath, family: Family) -> Iterator[Located]:
    """Where a symmetric path loses its symmetry."""
    balance = family(1)
    if balance.odd:
        for k in balance.stability(path.value, path.coefficients).changes.tolist():
            at = locate(Stretch.of(path, family, k), losing)
            if at is not None:
                yield at


def _broken(span: Range, partings: list[Located]) -> Iterator[tuple[float, Array]]:
    """Motions beside `partings` that are no longer symmetric."""
    for at in partings:
        beside = _beside(span.oscillator, at.value, at.coefficients)
        if beside is not None and span.low <= beside[0] <= span.high:
            yield beside


def _joined(path: BranchPath, partings: list[Located]) -> BranchPath:
    """A path that ends before a symmetric motion, with that motion."""
    omega, x, harmonics = path.value, path.coefficients, path.harmonics
    for end, place in ((1, len(omega)), (0, 0)):
        if path.ends[end].stop is Stop.SYMMETRY and partings:
            last = path.value[-end]
            near = min(partings, key=lambda at: abs(math.log(at.value / last)))
            at = resized(near.coefficients, harmonics_of(x))
            omega = np.insert(omega, place, near.value)
            x = np.insert(x, place, at, axis=0)
            harmonics = np.insert(harmonics, place, path.harmonics[-end])
    return replace(path, value=omega, coefficients=x, harmonics=harmonics)


def _beside(oscillator: Oscillator, omega: float, x: Array) -> tuple[float, Array] | None:
    """A motion in which even harmonics have grown to a twentieth, along Hill's null vector."""
    harmonics = len(x) // 2
    odd = Basis.odd(harmonics)
    even = odd.even()
    slope = tangent(even, oscillator, odd, x[odd.columns], omega)
    null = np.zeros(len(x))
    null[even.columns] = np.linalg.svd(slope)[2][-1]
    size = float(np.linalg.norm(x))
    equations = HarmonicBalance(oscillator, harmonics)
    across = np.append(null, 0.0)
    found = newton.correct(equations, x + 0.05 * size * null, math.log(omega), across, size, 1e-10)
    return None if found is None else (math.exp(found[0].p), found[0].x)


@dataclass(frozen=True)
class Describing:
    """Amplitudes W (n,), means m (n,) that balance the load, stiffness N (n,), and the `family`
    (n,) of neighbouring motions that each belongs to."""

    W: Array
    m: Array
    N: Array
    family: Array


def describing(oscillator: Oscillator) -> Describing:
    """The table for amplitudes up to what a hardening law or its domain lets through."""
    most = min(0.999 * oscillator.domain, 30.0 * max(1.0, oscillator.amplitude))
    levels = np.geomspace(1e-4 * min(1.0, oscillator.amplitude or 1.0), most, LEVELS)
    wave = np.cos(2 * np.pi * np.arange(SAMPLES) / SAMPLES)
    reach = np.minimum(4.0, 0.9999 * oscillator.domain - levels)
    # finer near 0, where quasi-zero stiffness makes wells close together
    side = np.linspace(0.0, 1.0, MEANS // 2 + 1) ** 2
    grid = reach[:, None] * np.concatenate([-side[:0:-1], side])

    def force(W: Array, m: Array) -> Array:
        return np.asarray(oscillator.force(m[..., None] + W[..., None] * wave))

    mean = force(np.broadcast_to(levels[:, None], grid.shape), grid).mean(axis=-1)
    rising = ~np.signbit(np.where(np.abs(mean) < 1e-15, 0.0, mean))
    level, place = np.nonzero(rising[:, :-1] != rising[:, 1:])
    W, low, high = levels[level], grid[level, place], grid[level, place + 1]
    goal = rising[level, place + 1]
    # all at once: scipy's root finders for arrays (optimize.elementwise) came with 1.15
    for _ in range(45):
        m = 0.5 * (low + high)
        above = (force(W, m).mean(axis=-1) >= 0) == goal
        low, high = np.where(above, low, m), np.where(above, m, high)
    m = 0.5 * (low + high)
    N = 2.0 * (force(W, m) * wave).mean(axis=-1) / W
    first = np.searchsorted(level, level)
    return Describing(W, m, N, (np.arange(len(level)) - first).astype(float))


def motions(oscillator: Oscillator, table: Describing, omega: float) -> Array:
    """(k, 3): mean, cos 1, sin 1 of the one-harmonic motions at Ω, interpolated in the table."""
    D, drive = 2 * oscillator.zeta * omega, float(oscillator.drive(omega))
    rows, found = np.stack([table.W, table.m, table.N]), [np.empty((3, 0))]
    for family in np.unique(table.family):
        own = rows[:, table.family == family]
        W, _, N = own
        excess = np.log(W) + 0.5 * np.log((N - omega**2) ** 2 + D**2 + 1e-300) - np.log(drive)
        k = np.flatnonzero(np.signbit(excess[:-1]) != np.signbit(excess[1:]))
        share = excess[k] / (excess[k] - excess[k + 1])
        found.append(own[:, k] + share * (own[:, k + 1] - own[:, k]))
        # near a fold two crossings hide between two levels
        turning = 1 + np.flatnonzero(np.diff(np.sign(np.diff(np.abs(excess)))) > 0)
        found.append(own[:, turning[np.abs(excess[turning]) < 0.5]])
    W, m, N = np.concatenate(found, axis=1)
    # (N - Ω² + iD) w = drive, its size taken from W
    w = W * np.exp(1j * np.angle(drive / (N - omega**2 + 1j * D)))
    return np.stack([m, w.real, -w.imag], axis=1)


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
    oscillator: Oscillator, omega: Array, known: Sequence[BranchPath], seed: int
) -> Iterator[tuple[float, Array]]:
    """Motions at each of `omega` that random disturbances of the `known` ones lead to."""
    rng = np.random.default_rng(seed)
    fading = 0.6 ** np.repeat(np.arange(HARMONICS + 1), 2)[1:]
    here = [(w, x) for w in omega.tolist() for path in known for x in crossings(path, w)]
    if here:
        places, middle = (
            np.array([w for w, _ in here]),
            np.array([resized(x, HARMONICS) for _, x in here]),
        )
        size = np.linalg.norm(middle, axis=1)[:, None, None]
        kicks = rng.normal(size=(len(here), KICKS, 2 * HARMONICS + 1)) * fading
        starts = (middle[:, None] + 0.4 * size * kicks).reshape(-1, 2 * HARMONICS + 1)
        again = list(_converged(oscillator, places, middle))
        if symmetric(oscillator):
            again += [(w, mirrored(x)) for w, x in again]
        yield from _converged(oscillator, np.repeat(places, KICKS), starts, again)


def crossings(path: BranchPath, omega: float) -> list[Array]:
    """Motions (2H + 1,) of a path where it passes `omega`, between its points."""
    here, ahead = path.value[:-1], path.value[1:]
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


def is_known(oscillator: Oscillator, omega: float, x: Array, known: Sequence[BranchPath]) -> bool:
    """Does one of the paths pass the motion x (2H + 1,) at `omega`, or its mirror image?"""
    images = (x, mirrored(x)) if symmetric(oscillator) else (x,)
    return any(
        _same_motion(oscillator, omega, guess, image)
        for path in known
        for guess in crossings(path, omega)
        for image in images
    )


def _same_motion(oscillator: Oscillator, omega: float, guess: Array, x: Array) -> bool:
    guess = resized(guess, harmonics_of(x))
    size = float(np.linalg.norm(x)) or 1.0
    if np.linalg.norm(guess - x) > 0.1 * size:
        return False
    here = np.array([omega])
    near = steady(oscillator, here, guess[None], 0.01 * _small(oscillator, here))
    if not near.converged[0]:
        return bool(np.linalg.norm(guess - x) < 0.02 * size)
    return bool(np.linalg.norm(near.coefficients[0] - x) < 1e-5 * size)


def _small(oscillator: Oscillator, omega: Array) -> float:
    """A residual that is small against the drive, and above rounding."""
    return float(max(1e-8 * np.min(oscillator.drive(omega)), 1e-14))


def _converged(
    oscillator: Oscillator,
    omega: Array,
    starts: Array,
    known: Sequence[tuple[float, Array]] = (),
) -> Iterator[tuple[float, Array]]:
    found = steady(oscillator, omega, starts, _small(oscillator, omega), 12)
    others: dict[float, list[Array]] = {w: [] for w in omega.tolist()}
    for w, x in known:
        others[w].append(x)
    for k in np.flatnonzero(found.converged):
        w, x = float(found.omega[k]), found.coefficients[k]
        size = np.linalg.norm(x)
        if not any(np.linalg.norm(x - y) < 1e-5 * size for y in others[w]):
            others[w].append(x)
            yield w, x
