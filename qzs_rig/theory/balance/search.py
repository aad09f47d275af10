"""Finding all branches of a range: from both its ends, from between, from broken symmetry."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from qzs_rig.samples import Array
from qzs_rig.theory.balance import newton
from qzs_rig.theory.balance.basis import Basis, harmonics_of, lopsided, resized, symmetric
from qzs_rig.theory.balance.branch import BranchPath, BranchProblem, Family, follow, refined
from qzs_rig.theory.balance.continuation import Stop
from qzs_rig.theory.balance.events import Located, Stretch, locate, losing
from qzs_rig.theory.balance.harmonic_balance import HarmonicBalance
from qzs_rig.theory.balance.initial_guesses import describing, is_known, kicked, one_term
from qzs_rig.theory.balance.stability import changes, floquet, tangent
from qzs_rig.theory.oscillator import Oscillator

BETWEEN = 24
"""Frequencies at which isolated branches are looked for."""
Found = list[tuple[BranchPath, Family]]
"""Paths with their equations."""


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
        partings = [at for path, family in found for at in _partings(span, path, family)]
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


def _partings(span: Range, path: BranchPath, family: Family) -> Iterator[Located]:
    """Where a symmetric path loses its symmetry."""
    if family(1).odd:
        other = floquet(span.oscillator, path.value, path.coefficients, odd=True).other
        for k in changes(other > 0).tolist():
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
