"""One point of a branch: what a motion leaves unbalanced, and Newton's way to none of it.

Written once for the interpreter and numba. A point y is the 2H + 1 coefficients of HarmonicBalance
followed by Ω. The period is sampled N, 2 N, 4 N, ... times: a stiff law swept over a large
amplitude needs more samples than harmonics tell, and `aliasing` says when.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from qzs_rig.theory.tracer.elimination import eliminate, substitute

BALANCED, LEFT, STALLED = range(3)
"""How `correct` ends: LEFT is off the law's domain."""


class Motion(NamedTuple):
    """The oscillator in numbers; `numbers` are its law's, the drive is amplitude Ω^power."""

    numbers: Any
    load: float
    zeta: float
    amplitude: float
    power: int
    domain: float


class Scratch(NamedTuple):
    """The waves (4H + 1, N + 2 N + ...) 1, cos τ, sin τ, cos 2τ, ... and room for one point.

    w, f, k hold the largest number of samples, kappa 4H + 1; rows are a square of 2H + 2, and the
    lines below have that length. `normal` is the row below the balance's slope: the corrector
    moves across it.
    """

    waves: Any
    coarsest: int
    w: Any
    f: Any
    k: Any
    kappa: Any
    rows: Any
    order: Any
    rest: Any
    normal: Any
    along: Any
    guess: Any
    weight: Any


def balance(sample: Any, motion: Any, scratch: Any, level: int, y: Any) -> float:
    """Fill `rest` with what y leaves unbalanced; its norm over the forces, NaN where y is off the
    domain of the law or Ω runs away."""
    w, f, rest = scratch.w, scratch.f, scratch.rest
    n, count = len(y) - 1, scratch.coarsest << level
    first, omega = count - scratch.coarsest, y[n]
    if not 0.0 < omega < 1e6:
        return math.nan
    synthesise(scratch, first, count, y)
    for j in range(count):
        # also true for NaN
        if not abs(w[j]) < motion.domain:
            return math.nan
    sample(motion.numbers, motion.load, count, w, f, scratch.k)
    analyse(scratch, f, first, count, rest, n, 2.0 / count)
    rest[0] *= 0.5
    rest[n] = 0.0
    for c in range(1, n, 2):
        rate = 0.5 * (c + 1) * omega
        square, damping = rate * rate, 2.0 * motion.zeta * rate
        rest[c] += damping * y[c + 1] - square * y[c]
        rest[c + 1] -= square * y[c + 1] + damping * y[c]
    rest[1] -= drive(motion, omega)
    size = 0.0
    for c in range(n):
        size += rest[c] * rest[c]
    return math.sqrt(size) / forces(motion, y)


def forces(motion: Any, y: Any) -> float:
    """What the parts of a balance are as large as: drive and inertia of the fundamental."""
    omega = y[len(y) - 1]
    inertia = omega * omega * (abs(y[1]) + abs(y[2]))
    return float(drive(motion, omega) + inertia)


def drive(motion: Any, omega: float) -> float:
    """Amplitude of the right-hand side."""
    push = motion.amplitude
    for _ in range(motion.power):
        push *= omega
    return float(push)


def synthesise(scratch: Any, first: int, count: int, y: Any) -> None:
    """Fill w with `count` samples of the motion, the waves' columns from `first` on."""
    w = scratch.w
    for j in range(count):
        w[j] = y[0]
    # by pairs: as fast as it gets without knowing how many there are
    for c in range(1, len(y) - 1, 2):
        x, z, cos, sin = y[c], y[c + 1], scratch.waves[c], scratch.waves[c + 1]
        for j in range(count):
            w[j] += x * cos[first + j] + z * sin[first + j]


def analyse(
    scratch: Any, values: Any, first: int, count: int, out: Any, n: int, scale: float
) -> None:
    """Fill the first n of `out`, an odd number, with `scale` times the sums over the waves."""
    mean = 0.0
    for j in range(count):
        mean += values[j]
    out[0] = scale * mean
    for c in range(1, n, 2):
        even, odd, cos, sin = 0.0, 0.0, scratch.waves[c], scratch.waves[c + 1]
        for j in range(count):
            even += values[j] * cos[first + j]
            odd += values[j] * sin[first + j]
        out[c], out[c + 1] = scale * even, scale * odd


def slope(motion: Any, scratch: Any, level: int, y: Any) -> None:
    """Fill `rows` with the slope of the last `balance` in y, and with the normal below it.

    Products of waves are waves of the sum and the difference: 4H + 1 coefficients of the
    stiffness make up the whole matrix.
    """
    kappa, rows, k = scratch.kappa, scratch.rows, scratch.k
    n, count = len(y) - 1, scratch.coarsest << level
    first, omega = count - scratch.coarsest, y[n]
    analyse(scratch, k, first, count, kappa, 2 * n - 1, 1.0 / count)
    rows[0][n] = 0.0
    for q in range(n):
        rows[0][q] = kappa[q]
        rows[n][q] = scratch.normal[q]
    rows[n][n] = scratch.normal[n]
    for p in range(1, n, 2):
        cos, sin = rows[p], rows[p + 1]
        cos[0], sin[0] = 2.0 * kappa[p], 2.0 * kappa[p + 1]
        for q in range(1, n, 2):
            # cosine and sine of harmonic m stand at 2 m - 1 and 2 m
            even, odd, apart = kappa[p + q + 1], kappa[p + q + 2], abs(p - q)
            near, side = kappa[0], 0.0
            if apart > 0:
                near, side = kappa[apart - 1], kappa[apart]
            if p < q:
                side = -side
            cos[q], sin[q + 1] = near + even, near - even
            cos[q + 1], sin[q] = odd - side, odd + side
        order = 0.5 * (p + 1)
        rate = order * omega
        damping, drag, turn = 2.0 * motion.zeta * rate, 2.0 * motion.zeta * order, 2.0 * order
        cos[p] -= rate * rate
        sin[p + 1] -= rate * rate
        cos[p + 1] += damping
        sin[p] -= damping
        cos[n] = drag * y[p + 1] - turn * rate * y[p]
        sin[n] = -turn * rate * y[p + 1] - drag * y[p]
    rows[1][n] -= motion.power * drive(motion, omega) / omega


def correct(sample: Any, motion: Any, scratch: Any, level: int, renew: bool, y: Any) -> int:
    """Newton across `normal`, which keeps its factors while they contract; how it ended.

    With `renew`, `rows` are factorised at the solution, else somewhere near.
    """
    before = math.inf
    for _ in range(12):
        size = balance(sample, motion, scratch, level, y)
        if not size < math.inf:
            return LEFT
        if size <= 1e-12:
            if renew:
                slope(motion, scratch, level, y)
                eliminate(scratch.rows, scratch.order)
            return BALANCED
        if size > 0.05 * before or before == math.inf:
            slope(motion, scratch, level, y)
            eliminate(scratch.rows, scratch.order)
        rate, before = size / before, size
        substitute(scratch.rows, scratch.order, scratch.rest)
        for c in range(len(y)):
            y[c] -= scratch.rest[c]
        # the next balance would say so: the same factors contract at the same rate
        if 10.0 * size * rate <= 1e-12 and 0.0 < rate < 0.05 and not renew:
            return BALANCED
    return STALLED


def aliasing(motion: Any, scratch: Any, level: int, y: Any) -> float:
    """By how much the last `balance` would differ with every other sample, over the forces.
    Leaves every other sign of f turned."""
    f, n, count = scratch.f, len(y) - 1, scratch.coarsest << level
    first, square = count - scratch.coarsest, 0.0
    for j in range(1, count, 2):
        f[j] = -f[j]
    analyse(scratch, f, first, count, scratch.kappa, n, 2.0 / count)
    for c in range(n):
        square += scratch.kappa[c] * scratch.kappa[c]
    return float(math.sqrt(square) / forces(motion, y))


def hold(scratch: Any, y: Any, omega: float) -> None:
    """Put y at the frequency `omega`, and let the corrector leave it there."""
    n = len(y) - 1
    y[n] = omega
    for c in range(n):
        scratch.normal[c] = 0.0
    scratch.normal[n] = 1.0
