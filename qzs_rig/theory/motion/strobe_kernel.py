"""Runs side by side, a period at a time: the source of the compiled stroboscope.

`advance` is what costs time, `sweep` the bookkeeping of it. Both are templates for
mechanics.specialise: the names below `Formulas put in` are replaced by what they stand for.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from qzs_rig.mechanics.restoring.law import Formula
from qzs_rig.mechanics.restoring.polynomial import cubic_force
from qzs_rig.theory.motion.splitting import STAGES
from qzs_rig.theory.motion.strobe_cycles import BACK, LANES, finish, look_back, returned

# Formulas put in: the law, and how a lane finds its design.
force: Formula = cubic_force
"""F(w), net of the static load: a cubic law's where no other is put in."""


def shared(design: Any, lane: int) -> Any:
    """The design of a lane where all have the same."""
    return design


def each(design: Any, lane: int) -> Any:
    """The design of a lane where each has its own."""
    return (
        design[0, lane],
        design[1, lane],
        design[2, lane],
        design[3, lane],
        design[4, lane],
        design[5, lane],
    )


def keep_shared(block: Any, design: Any, lane: int, run: int) -> None:
    """Nothing to hand to a lane."""


def take_own(block: Any, design: Any, lane: int, run: int) -> None:
    """Hand the design of a run to a lane."""
    for row in range(len(block)):
        block[row, lane] = design[row, run]


at, take = shared, keep_shared


def advance(
    block: Any, moving: Any, decay: Any, reach: Any, weights: Any, cosines: Any, wave: Any
) -> None:
    """One period of all lanes.

    `moving` (10, LANES): w, w'/h, step h, drive, load, then Σ w cos, Σ w sin, lowest and highest
    w over the step ends, and what h is at omega = 1. `decay`, `reach` (11, LANES); `weights`,
    `cosines` (11 steps + 1); `wave` (steps, 2) cos and sin of the phase at the step ends.
    """
    w, y, drive, load = moving[0], moving[1], moving[3], moving[4]
    cos, sin, low, high = moving[5], moving[6], moving[7], moving[8]
    for lane in range(LANES):
        push = drive[lane] * cosines[0] + load[lane] - force(at(block, lane), w[lane])
        y[lane] += weights[0] * push
        cos[lane] = sin[lane] = 0.0
        low[lane] = high[lane] = w[lane]
    for step in range(len(wave)):
        for stage in range(STAGES):
            k = STAGES * step + stage + 1
            c, weight, d, r = cosines[k], weights[k], decay[stage], reach[stage]
            for lane in range(LANES):
                x = w[lane] + r[lane] * y[lane]
                w[lane] = x
                push = drive[lane] * c + load[lane] - force(at(block, lane), x)
                y[lane] = d[lane] * y[lane] + weight * push
        c, s = wave[step]
        for lane in range(LANES):
            cos[lane] += c * w[lane]
            sin[lane] += s * w[lane]
            low[lane] = min(low[lane], w[lane])
            high[lane] = max(high[lane], w[lane])


def board(lane: int, run: int, runs: Any, drifts: Any, moving: Any, decay: Any, reach: Any) -> None:
    """Put a run on a lane: `moving[2]` holds what a step is at omega = 1."""
    zeta, drive, omega, load = runs[0, run], runs[1, run], runs[2, run], runs[3, run]
    h = moving[9, lane] / omega
    for stage in range(STAGES):
        s = drifts[stage] * h
        decay[stage, lane] = np.exp(-2.0 * zeta * s)
        far = -np.expm1(-2.0 * zeta * s) / (2.0 * zeta) if zeta > 0.0 else s
        # velocities over h: so no kick needs h
        reach[stage, lane] = h * far
    moving[0, lane], moving[1, lane] = runs[4, run], runs[5, run] / h
    moving[2, lane], moving[3, lane], moving[4, lane] = h, drive, load


def remember(past: Any, slot: int, moving: Any) -> None:
    """Put w, w' and the four sums of this period into `past` (6, BACK, LANES)."""
    for lane in range(LANES):
        past[0, slot, lane] = moving[0, lane]
        past[1, slot, lane] = moving[2, lane] * moving[1, lane]
    for row in range(2, 6):
        for lane in range(LANES):
            past[row, slot, lane] = moving[row + 3, lane]


def lose(points: Any, figures: Any, place: int) -> None:
    """NaN for what a run that has left the law would still have given."""
    for k in range(max(place, 0), points.shape[1]):
        points[0, k] = points[1, k] = np.nan
    for k in range(len(figures)):
        figures[k] = np.nan


def workspace(steps: int) -> tuple[Any, ...]:
    """Arrays that `sweep` works in: moving, past, decay, reach, found, and (2, LANES) the run that
    a lane carries, -1 without one, and its age in periods."""
    moving = np.zeros((10, LANES))
    moving[9] = 2.0 * np.pi / steps
    lanes = np.zeros((2, LANES), np.int64)
    lanes[0] = -1
    stages = np.zeros((2, STAGES, LANES))
    return moving, np.zeros((6, BACK, LANES)), stages[0], stages[1], np.zeros(LANES), lanes


def sweep(
    advance: Any,
    work: Any,
    design: Any,
    block: Any,
    runs: Any,
    drifts: Any,
    weights: Any,
    cosines: Any,
    wave: Any,
    periods: int,
    longest: int,
    early: bool,
    tolerance: float,
    limit: float,
    points: Any,
    cycle: Any,
    settled: Any,
    figures: Any,
) -> None:
    """Carry `runs` (6, n) of rows zeta, drive, omega, load, w, w' through `periods`.

    A lane that has done its run takes the next. A run has settled where it repeats itself within
    `tolerance` after `longest` periods or fewer; with `early` it is then done, and what it would
    still do is filled in. Fills `points` (n, 2, keep), w and w' after each of the last periods;
    `cycle` (n,) the period found, -1 where |w| reached `limit`, and `settled` (n,) when that was;
    both stay where there is none. `figures` (n, 6): w, w' at the end, mean cosine and sine part,
    lowest and highest w over the cycle or, without one, over the last 32 periods.
    """
    n, keep = points.shape[0], points.shape[2]
    moving, past, decay, reach, found, lanes = work
    carried, age = lanes[0], lanes[1]
    following, busy, slot = 0, 0, 0
    while True:
        for lane in range(LANES):
            if carried[lane] < 0 and following < n:
                board(lane, following, runs, drifts, moving, decay, reach)
                take(block, design, lane, following)
                carried[lane], age[lane] = following, 0
                following, busy = following + 1, busy + 1
        if busy == 0:
            return
        advance(block, moving, decay, reach, weights, cosines, wave)
        slot = (slot + 1) % BACK
        remember(past, slot, moving)
        look_back(past, slot, longest, tolerance, found)
        for lane in range(LANES):
            run = carried[lane]
            if run < 0:
                continue
            age[lane] += 1
            place = age[lane] - (periods - keep) - 1
            if place >= 0:
                points[run, 0, place] = past[0, slot, lane]
                points[run, 1, place] = past[1, slot, lane]
            period = int(found[lane])
            if not (moving[8, lane] < limit and moving[7, lane] > -limit):
                cycle[run], settled[run] = -1, age[lane]
                lose(points[run], figures[run], place)
                carried[lane], busy = -1, busy - 1
                continue
            left = np.inf
            if period > 0:
                scale = max(1.0, moving[2, lane] / moving[9, lane])
                left = returned(past, slot, lane, period, age[lane], scale, tolerance)
            if cycle[run] == 0 and left <= tolerance:
                cycle[run], settled[run] = period, age[lane]
            if age[lane] == periods or (early and cycle[run] > 0):
                period = cycle[run]
                finish(past, slot, lane, period, age[lane], periods, points[run], figures[run])
                carried[lane], busy = -1, busy - 1
