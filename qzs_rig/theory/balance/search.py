"""Finding all branches of a range: from both its ends, from between, from broken symmetry."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from qzs_rig.samples import Array
from qzs_rig.theory.balance import newton
from qzs_rig.theory.balance.basis import Basis, harmonics_of, lopsided, resized, symmetric
from qzs_rig.theory.balance.branch import BranchPath, BranchProblem, follow, refined
from qzs_rig.theory.balance.continuation import Stop
from qzs_rig.theory.balance.events import Located, Stretch, doubling, locate
from qzs_rig.theory.balance.harmonic_balance import BalanceEquations, tangent
from qzs_rig.theory.balance.initial_guesses import describing, is_known, kicked, one_term
from qzs_rig.theory.balance.stability import floquet
from qzs_rig.theory.oscillator import Oscillator

BETWEEN = 24
"""Frequencies at which isolated branches are looked for."""
Found = list[tuple[BranchPath, bool]]


@dataclass(frozen=True)
class Range:
    """What is looked at, and how."""

    oscillator: Oscillator
    low: float
    high: float
    harmonics: int | None
    tolerance: float = 1e-10

    def problem(self, omega: float, x: Array, odd: bool) -> BranchProblem:
        """To follow the branch of the motion x (2H + 1,) at `omega`."""
        return BranchProblem(
            self.oscillator, omega, x, self.low, self.high, odd, self.harmonics, self.tolerance
        )


def paths(span: Range, isolas: bool, tell: Callable[[float, str], None]) -> Found:
    """Every path, each with whether it is in odd harmonics; those at the upper end first."""
    found: Found = []
    odd, table = symmetric(span.oscillator), describing(span.oscillator)
    ends = np.array([span.high, span.low])
    tell(0.0, 'branches from the ends of the range')
    _follow(span, one_term(span.oscillator, ends, table), found, odd)
    between = np.geomspace(span.low, span.high, BETWEEN + 2)[1:-1]
    if isolas or not found:
        tell(0.3, 'isolated branches')
        _follow(span, one_term(span.oscillator, between, table), found, odd)
    if odd:
        tell(0.5, 'broken symmetry')
        partings = [at for path, own in found if own for at in _partings(span, path)]
        _follow(span, _broken(span, partings), found, odd)
        found = [(_joined(path, partings), own) for path, own in found]
    if isolas:
        tell(0.6, 'isolated branches')
        known = [path for path, _ in found]
        _follow(span, kicked(span.oscillator, between, known, seed=1), found, odd)
    return found


def least_path(span: Range, omega: float) -> tuple[BranchPath, bool] | None:
    """The path of the smallest motion at `omega`, and whether it is in odd harmonics."""
    odd = symmetric(span.oscillator)
    guesses = sorted(
        one_term(span.oscillator, np.array([omega])), key=lambda at: np.linalg.norm(at[1])
    )
    for _, x in guesses:
        start = refined(span.problem(omega, x, odd and lopsided(x) < 1e-6))
        if start is not None:
            problem = span.problem(omega, start, odd and lopsided(start) < 1e-6)
            return follow(problem), problem.odd
    return None


def _follow(span: Range, seeds: Iterator[tuple[float, Array]], found: Found, odd: bool) -> None:
    for omega, x in seeds:
        own = odd and lopsided(x) < 1e-6
        problem = span.problem(omega, x, own)
        if is_known(problem, [path for path, _ in found]):
            continue
        start = refined(problem)
        if start is None:
            continue
        problem = span.problem(omega, start, odd and lopsided(start) < 1e-6)
        if not is_known(problem, [path for path, _ in found]):
            found.append((follow(problem), problem.odd))


def _partings(span: Range, path: BranchPath) -> list[Located]:
    """Where the symmetric `path` loses its symmetry."""
    other = floquet(span.oscillator, path.omega, path.coefficients, odd=True).other
    found = []
    for k in np.flatnonzero((other[:-1] > 0) != (other[1:] > 0)):
        pair = slice(k, k + 2)
        x, harmonics = path.coefficients[pair], int(path.harmonics[pair].max())
        unknowns = partial(BalanceEquations, span.oscillator, odd=True)
        at = locate(Stretch(unknowns, path.omega[pair], x, harmonics), doubling)
        if at is not None:
            found.append(at)
    return found


def _broken(span: Range, partings: list[Located]) -> Iterator[tuple[float, Array]]:
    """Motions beside `partings` that are no longer symmetric."""
    for at in partings:
        beside = _beside(span.oscillator, at.omega, at.coefficients)
        if beside is not None and span.low <= beside[0] <= span.high:
            yield beside


def _joined(path: BranchPath, partings: list[Located]) -> BranchPath:
    """A path that ends before a symmetric motion, with that motion."""
    omega, x, harmonics = path.omega, path.coefficients, path.harmonics
    for end, place in ((1, len(omega)), (0, 0)):
        if path.ends[end].stop is Stop.SYMMETRY and partings:
            last = path.omega[-end]
            near = min(partings, key=lambda at: abs(math.log(at.omega / last)))
            at = resized(near.coefficients, harmonics_of(x))
            omega = np.insert(omega, place, near.omega)
            x = np.insert(x, place, at, axis=0)
            harmonics = np.insert(harmonics, place, path.harmonics[-end])
    return replace(path, omega=omega, coefficients=x, harmonics=harmonics)


def _beside(oscillator: Oscillator, omega: float, x: Array) -> tuple[float, Array] | None:
    """A motion in which even harmonics have grown to a twentieth, along Hill's null vector."""
    harmonics = len(x) // 2
    odd = Basis.odd(harmonics)
    even = odd.even()
    slope = tangent(even, oscillator, odd, x[odd.columns], omega)
    null = np.zeros(len(x))
    null[even.columns] = np.linalg.svd(slope)[2][-1]
    size = float(np.linalg.norm(x))
    equations = BalanceEquations(oscillator, harmonics)
    across = np.append(null, 0.0)
    found = newton.correct(equations, x + 0.05 * size * null, math.log(omega), across, size, 1e-10)
    return None if found is None else (math.exp(found[0].p), found[0].x)
