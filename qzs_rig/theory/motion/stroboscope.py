"""Runs seen once a period, when the base is at its highest: Poincaré's map, many at a time."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import InputError
from qzs_rig.samples import Array
from qzs_rig.theory.motion import splitting
from qzs_rig.theory.motion.lanes import Lanes
from qzs_rig.theory.motion.strobe_engine import spread, sweeping
from qzs_rig.theory.motion.strobe_kernel import workspace

LONGEST = 16
"""Periods of the longest cycle that is looked for."""

RETURN = 1e-8
"""A run has settled where what is left of its transient is below this."""

FAR = 1e6
"""|w| from which a run counts as lost where its law holds anywhere."""


@dataclass(frozen=True)
class Stroboscope:
    """What n runs of `lanes` did, `steps` (n,) a period.

    `w` and `velocity` (n, keep) stand after each of the last `keep` of `periods`. `period` (n,) is
    1, 2, … where a run repeats itself after that many, 0 where it had not settled by the end, -1
    where it left its law's domain (the rest is NaN); `settled` (n,) is when that was found. The
    figures cover the cycle, or the last 32 periods: `end` (n, 2) w and w', `fundamental` (n,)
    complex, w = Re(fundamental e^{iΩτ}) + …, `low` and `high` (n,) of w over the steps.
    `error` (n,) is how much finer steps change w, NaN where that was not measured.
    """

    lanes: Lanes
    steps: NDArray[np.int64]
    periods: int
    w: Array
    velocity: Array
    period: NDArray[np.int64]
    settled: NDArray[np.int64]
    end: Array
    fundamental: NDArray[np.complex128]
    low: Array
    high: Array
    error: Array

    @property
    def transmissibility(self) -> NDArray[np.complex128]:
        """(n,) u/v of the fundamentals; its angle is the phase of the top against the base. NaN
        where the base is at rest."""
        base = np.where(self.lanes.base > 0.0, self.lanes.base, np.nan)
        with np.errstate(invalid='ignore'):
            return np.asarray(1.0 + self.fundamental / base)

    @property
    def largest(self) -> Array:
        """(n,) largest |w| of the cycle or the last periods."""
        return np.maximum(-self.low, self.high)


def strobe(
    lanes: Lanes,
    *,
    steps: int,
    periods: int = 500,
    keep: int = 400,
    early: bool = True,
    phase: float = 0.0,
    tolerance: float = RETURN,
    workers: int | None = None,
) -> Stroboscope:
    """All runs through `periods` in `steps` a period; `keep` = 0 keeps the figures only.

    With `early` a run ends where it repeats itself within `tolerance`, and the cycle found stands
    for the rest. The runs start, and are seen, where the base's phase is `phase`: 0 at its highest,
    π at its lowest. Memory: (2 keep + 16) numbers a run. `workers` threads, by default all cores.
    """
    _check(steps, periods, keep)
    n = len(lanes)
    points = np.empty((n, 2, keep))
    period, settled = np.zeros(n, dtype=np.int64), np.full(n, periods, dtype=np.int64)
    figures = np.empty((n, 6))
    sweep = sweeping(lanes.law, lanes.number, lanes.shared)
    turned = 2.0 * np.pi * np.arange(1, steps + 1) / steps + phase
    schedule = (
        splitting.DRIFTS,
        splitting.kick_weights(steps),
        splitting.kick_cosines(steps, phase),
        np.ascontiguousarray(np.stack([np.cos(turned), np.sin(turned)], axis=-1)),
    )
    limit = min(lanes.law.domain[lanes.number], FAR)

    def part(which: slice) -> None:
        own = lanes[which]
        design = tuple(own.design.tolist()) if own.shared else own.design
        work = workspace(steps)
        block = design if own.shared else np.ones((6, work[0].shape[1]))
        results = points[which], period[which], settled[which], figures[which]
        rules = periods, LONGEST, early, tolerance, limit
        with np.errstate(all='ignore'):
            sweep(work, design, block, own.table, *schedule, *rules, *results)

    spread(part, n, workers)
    return Stroboscope(
        lanes=lanes,
        steps=np.full(n, steps),
        periods=periods,
        w=points[:, 0],
        velocity=points[:, 1],
        period=period,
        settled=settled,
        end=figures[:, :2],
        fundamental=np.asarray((figures[:, 2] - 1j * figures[:, 3]) * (2.0 / steps)),
        low=figures[:, 4],
        high=figures[:, 5],
        error=np.full(n, math.nan),
    )


def _check(steps: int, periods: int, keep: int) -> None:
    if steps < 1:
        raise InputError(f'{steps} steps a period; give 1 or more')
    if periods < 1:
        raise InputError(f'{periods} periods; give 1 or more')
    if not 0 <= keep <= periods:
        raise InputError(f'{keep} of {periods} periods kept; give 0 to {periods}')
