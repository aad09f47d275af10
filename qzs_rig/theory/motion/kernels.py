"""Runs side by side through one period of the base, compiled: what theory in time is made of.

A step is SRKN_11^b of S. Blanes, P. C. Moan, J. Comput. Appl. Math. 142 (2002) 313: order 6 for
w'' = f(w, τ), eleven drifts and kicks. Damping goes into the drift, where it is exact: of
w'' = -2 ζ w' are left w' e^(-2ζs) and w + w' (1 - e^(-2ζs))/(2ζ) after s. The conditions of order
rest on kicks that commute with their own commutators, which this drift, linear in w', does not
disturb.

`advancing` compiles a period around the force of a law. Everything else knows no law: it takes that
period as an argument and is compiled once. numba keeps all of it on disk and compiles it anew where
this file or a law's formula is edited; after an edit of this file, save `cycles`, too. Where a
package is installed without .pyc files, the second process compiles once more: numba's key has the
pickled formula, whose constants are other objects when Python has loaded them from a .pyc.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import float64, int64, typeof, types, void
from numba.extending import register_jitable

from qzs_rig.mechanics.compiling import kept
from qzs_rig.mechanics.restoring.law import RestoringLaw, fast_rsqrt, teach_numba
from qzs_rig.samples import Array
from qzs_rig.theory.motion.batch import DRIVE, LOAD, OMEGA, VELOCITY, WIDTH, ZETA, W

ORDER = 6

_B = (
    0.0414649985182624,
    0.198128671918067,
    -0.0400061921041533,
    0.0752539843015807,
    -0.0115113874206879,
)
_A = (
    0.123229775946271,
    0.290553797799558,
    -0.127049212625417,
    -0.246331761062075,
    0.357208872795928,
)

DRIFTS = np.array([*_A, 1.0 - 2.0 * sum(_A), *_A[::-1]])
"""(11,) lengths of the drifts over the step."""

KICKS = np.array([*_B, 0.5 - sum(_B), 0.5 - sum(_B), *_B[::-1]])
"""(12,) weights of the kicks: one before each drift and one after the last, which the first of
the next step joins."""

STAGES = len(DRIFTS)


def kick_weights(steps: int) -> Array:
    """(11 steps + 1,) weights of all kicks of a period of `steps`, those between steps joined."""
    inner = np.tile(np.append(KICKS[1:-1], 2.0 * KICKS[0]), steps)
    inner[-1] = KICKS[0]
    return np.append(KICKS[0], inner)


class Schedule(NamedTuple):
    """Kicks of `steps` steps: `weights` (11 steps + 1,), `cosines` (11 steps + 1,) of the base's
    phase then, `wave` (steps, 2) its cosine and sine at the step ends; `step` is the length of a
    step in phase. The same for every frequency."""

    weights: Array
    cosines: Array
    wave: Array
    step: float


def schedule(steps: int, phase: float = 0.0) -> Schedule:
    """A period of `steps` that begins at the base's `phase`."""
    when = np.concatenate([[0.0], np.cumsum(np.tile(DRIFTS, steps))]) / steps
    turned = 2.0 * np.pi * np.arange(1, steps + 1) / steps + phase
    return Schedule(
        kick_weights(steps),
        np.cos(2.0 * np.pi * when + phase),
        np.stack([np.cos(turned), np.sin(turned)], axis=-1),
        2.0 * np.pi / steps,
    )


def single_steps(whole: Schedule) -> list[Schedule]:
    """The steps of a schedule one by one: each ends with a kick of its own, so that the velocity
    stands at the same time as w."""
    weights = kick_weights(1)
    return [
        Schedule(
            weights, whole.cosines[STAGES * k :][: STAGES + 1], whole.wave[k : k + 1], whole.step
        )
        for k in range(len(whole.wave))
    ]


SHIFT = 1e-5
"""Half the base of the difference that is F': SHIFT² F'''/6 and rounding/SHIFT are about 1e-10."""

FAST = {'contract', 'reassoc', 'arcp', 'afn', 'nsz'}
"""Arithmetic that may be regrouped; numbers that are not finite stay what they are."""


class Block(NamedTuple):
    """WIDTH runs that move together, a column each.

    `w` (m, WIDTH) is the relative motion and, with m = 2, a small disturbance of it; `y` (m, WIDTH)
    are their velocities over the step `h`, so that no kick needs h. `numbers` (count, WIDTH) are
    what the law's force takes. `decay` and `reach` (12, WIDTH): what a drift leaves of y, and what
    of it is added to w; the last is no drift. `cos`, `sin` (WIDTH,) are sums of w times those of
    the base's phase over the step ends of a period, `low` and `high` (WIDTH,) its extremes there.
    """

    w: Array
    y: Array
    numbers: Array
    decay: Array
    reach: Array
    h: Array
    drive: Array
    load: Array
    cos: Array
    sin: Array
    low: Array
    high: Array


def block(count: int, motions: int = 1) -> Block:
    """Room for WIDTH runs with `count` numbers: their motion and `motions` - 1 disturbances."""
    pair, stages = np.zeros((2, motions, WIDTH)), np.zeros((2, STAGES + 1, WIDTH))
    stages[0, STAGES] = 1.0
    w, y = pair
    return Block(w, y, np.ones((count, WIDTH)), *stages, *np.zeros((7, WIDTH)))


GRID = float64[:, ::1]
BLOCK, SCHEDULE = typeof(block(1)), typeof(schedule(1))
PERIOD = types.FunctionType(void(BLOCK, SCHEDULE))
"""numba's type of what `advancing` returns."""


@cache
def advancing(law: RestoringLaw, number: int) -> Any:
    """One period of a Block under the law of a degree of freedom, for the Schedule of a period."""
    teach_numba()
    force = law.compilable(number, fast_rsqrt)
    register_jitable(error_model='numpy')(force)
    compiled = kept(void(BLOCK, SCHEDULE), error_model='numpy', fastmath=FAST)
    return compiled(period_around(force, law.count))


def gathering(count: int) -> Any:
    """A function that returns the first `count` rows, 3 or more, of p at a column as a tuple.

    A compiled tuple has its length from the code: the three numbers of a cubic and the six of a
    design are written out, which compiles soon; each further one is added to the tuple before.
    """
    if count == 3:

        def gather(p: Any, column: int) -> Any:
            return p[0, column], p[1, column], p[2, column]

    elif count == 6:

        def gather(p: Any, column: int) -> Any:
            three = p[0, column], p[1, column], p[2, column]
            return (*three, p[3, column], p[4, column], p[5, column])

    else:
        before, last = gathering(count - 1), count - 1

        def gather(p: Any, column: int) -> Any:
            return (*before(p, column), p[last, column])

    # a call would count references to p, which keeps loops around it from vector instructions
    return register_jitable(inline='always')(gather)


def period_around(force: Any, count: int) -> Any:
    """The period of `advancing`, not compiled, for a force of `count` numbers."""
    gather = gathering(count)

    def advance(runs: Any, schedule: Any) -> None:
        w, y, drive, load = runs.w[0], runs.y[0], runs.drive, runs.load
        for column in range(WIDTH):
            runs.cos[column] = runs.sin[column] = 0.0
            runs.low[column] = runs.high[column] = w[column]
        for k in range(len(schedule.weights)):
            # the first kick has no drift before it
            stage, weight = (k - 1) % STAGES if k > 0 else STAGES, schedule.weights[k]
            decay, reach, cosine = runs.decay[stage], runs.reach[stage], schedule.cosines[k]
            for column in range(WIDTH):
                x = w[column] + reach[column] * y[column]
                own = gather(runs.numbers, column)
                push = drive[column] * cosine + load[column] - force(own, x)
                w[column], y[column] = x, decay[column] * y[column] + weight * push
            if len(runs.w) > 1:
                dw, dy = runs.w[1], runs.y[1]
                for column in range(WIDTH):
                    own = gather(runs.numbers, column)
                    x = w[column]
                    slope = (force(own, x + SHIFT) - force(own, x - SHIFT)) * (0.5 / SHIFT)
                    dx = dw[column] + reach[column] * dy[column]
                    dw[column], dy[column] = dx, decay[column] * dy[column] - weight * slope * dx
            if stage == STAGES - 1:
                cos, sin = schedule.wave[(k - 1) // STAGES]
                for column in range(WIDTH):
                    runs.cos[column] += cos * w[column]
                    runs.sin[column] += sin * w[column]
                    runs.low[column] = min(runs.low[column], w[column])
                    runs.high[column] = max(runs.high[column], w[column])

    return advance


@register_jitable
def begin(runs: Any, column: int, table: Any, numbers: Any, run: int, schedule: Any) -> None:
    """Put a run, a column of Batch.table and Batch.numbers, at its start into a block."""
    zeta, h = table[ZETA, run], schedule.step / table[OMEGA, run]
    for stage in range(STAGES):
        s = DRIFTS[stage] * h
        runs.decay[stage, column] = np.exp(-2.0 * zeta * s)
        far = -np.expm1(-2.0 * zeta * s) / (2.0 * zeta) if zeta > 0.0 else s
        runs.reach[stage, column] = h * far
    for row in range(len(numbers)):
        runs.numbers[row, column] = numbers[row, run]
    runs.w[0, column], runs.y[0, column] = table[W, run], table[VELOCITY, run] / h
    runs.h[column], runs.drive[column], runs.load[column] = h, table[DRIVE, run], table[LOAD, run]


@kept(void(PERIOD, BLOCK, GRID, GRID, SCHEDULE, int64, GRID, GRID))
def grow(
    advance: Any,
    runs: Any,
    table: Any,
    numbers: Any,
    schedule: Any,
    before: int,
    growth: Any,
    ends: Any,
) -> None:
    """Fill `growth` (n, periods) with what log |δ| gains in every period, after `before` others.

    δ is the disturbance, obeying δw'' + 2ζ δw' + F'(w) δw = 0 in the same drifts and kicks as w:
    the exact derivative of the numerical map, but for F', a central difference good to 1e-9. A run
    that is lost leaves what is not finite. `ends` (n, 2) takes w and w' at the end.
    """
    n, periods = growth.shape
    for first in range(0, n, WIDTH):
        for column in range(WIDTH):
            begin(runs, column, table, numbers, min(first + column, n - 1), schedule)
            runs.w[1, column], runs.y[1, column] = 1.0, 0.0
        for period in range(before + periods):
            advance(runs, schedule)
            for column in range(WIDTH):
                size = np.sqrt(runs.w[1, column] ** 2 + runs.y[1, column] ** 2)
                runs.w[1, column] /= size
                runs.y[1, column] /= size
                if period >= before and first + column < n:
                    growth[first + column, period - before] = np.log(size)
        for column in range(min(WIDTH, n - first)):
            ends[first + column, 0] = runs.w[0, column]
            ends[first + column, 1] = runs.h[column] * runs.y[0, column]
