"""The kernels that trace a curve, put together for numba or the interpreter."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from qzs_rig.mechanics.specialise import Function, compiled
from qzs_rig.samples import Array
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.theory.tracer import balancing, elimination, following, liouville, sampled, settling
from qzs_rig.theory.tracer.balancing import Motion, Scratch
from qzs_rig.theory.tracer.following import Walk

SAMPLES = 1024
"""At most so many a period, where a law needs them."""

SUMS: set[str] = {'reassoc', 'contract'}
"""Sums may be taken in any order: vector code, whose last digits differ from the interpreter's."""

CORRECT = (
    elimination.eliminate,
    elimination.substitute,
    balancing.drive,
    balancing.forces,
    balancing.synthesise,
    balancing.analyse,
    balancing.balance,
    balancing.slope,
)
SETTLE = (balancing.drive, balancing.analyse, settling.acceleration, settling.advance)
FOLLOW = (
    elimination.orientation,
    elimination.substitute,
    balancing.drive,
    balancing.forces,
    balancing.analyse,
    balancing.aliasing,
    balancing.hold,
    following.keep,
    following.distance,
    following.weigh,
    following.extrapolate,
    following.depart,
    following.begin,
    following.crossed,
    following.is_home,
)
MONODROMIES = (balancing.synthesise, liouville.resolution, liouville.trace_of)
"""What the kernels are made of; each part knows those before it."""


class Kernels(NamedTuple):
    """`follow`, the two that it takes as arguments, and `monodromies`. All take `lists` in place of
    arrays, or none."""

    follow: Function
    settle: Function
    correct: Function
    monodromies: Function
    lists: bool


class Waves(NamedTuple):
    """(4H + 1, N + 2 N + ...) as Scratch says, N, and how often N is doubled."""

    table: Array
    coarsest: int
    finest: int


@cache
def waves(harmonics: int, coarsest: int) -> Waves:
    """The waves of a period sampled `coarsest`, twice, four times, ... as often."""
    finest = max(1, int(np.log2(SAMPLES / coarsest)))
    parts = [np.arange(coarsest << level) / (coarsest << level) for level in range(finest + 1)]
    angle = 2 * np.pi * np.outer(np.arange(1, 2 * harmonics + 1), np.concatenate(parts))
    table = np.ones((4 * harmonics + 1, angle.shape[1]))
    table[1::2], table[2::2] = np.cos(angle), np.sin(angle)
    return Waves(table, coarsest, finest)


def motion(oscillator: Oscillator) -> Motion:
    """The oscillator in numbers."""
    return Motion(
        sampled.numbers(oscillator),
        float(oscillator.load),
        float(oscillator.zeta),
        float(oscillator.amplitude),
        2 - oscillator.falloff,
        float(oscillator.domain),
    )


def scratch(harmonics: int, of: Waves, lists: bool) -> Scratch:
    """Room for one thread."""
    n, samples = 2 * harmonics + 2, of.coarsest << of.finest
    room: list[Any] = [np.zeros(size) for size in (samples, samples, samples, 2 * n - 3)]
    room += [np.zeros((n, n)), np.zeros(n, dtype=np.int64), *np.zeros((5, n))]
    table: Any = of.table
    if lists:
        table, room = _listed(harmonics, of.coarsest), [each.tolist() for each in room]
    return Scratch(table, of.coarsest, *room)


@cache
def _listed(harmonics: int, coarsest: int) -> Any:
    return waves(harmonics, coarsest).table.tolist()


def _parts(of: Iterable[Function]) -> dict[str, Function]:
    return {part.__name__: part for part in of}


@cache
def in_interpreter() -> Kernels:
    """Templates as they are: some hundred times slower."""
    return Kernels(
        following.follow, settling.settle, balancing.correct, liouville.monodromies, lists=True
    )


@cache
def in_numba() -> Kernels:
    """One set for every law and number of harmonics; ImportError where numba is missing.

    Parts are pointers to each other: inlined, each would be optimised once more in the next.
    """
    from numba import boolean, float64, int64, typeof, types, void

    def kernel(template: Function, parts: Iterable[Function], signature: Any) -> Function:
        return compiled(template, _parts(parts), fastmath=SUMS, signature=signature)

    # numba's own types carry no annotations
    pair: Any = types.UniTuple
    type_of: Any = typeof
    line, grid = float64[::1], float64[:, ::1]
    numbers = type_of(Motion((0.0,) * 6, 0.0, 0.0, 0.0, 2, 0.0))
    room = type_of(scratch(1, waves(1, 16), lists=False))
    walk = type_of(Walk(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, settling=True, finest=1))
    law = sampled.pointer(), numbers, room
    settles, corrects = void(*law, line), int64(*law, int64, boolean, line)
    pointers = sampled.pointer(), types.FunctionType(settles), types.FunctionType(corrects)
    follows = pair(int64, 2)(*pointers, numbers, room, walk, line, grid, line)
    return Kernels(
        kernel(following.follow, FOLLOW, follows),
        kernel(settling.settle, SETTLE, settles),
        kernel(balancing.correct, CORRECT, corrects),
        kernel(liouville.monodromies, MONODROMIES, void(*law, int64, grid, int64, line)),
        lists=False,
    )
