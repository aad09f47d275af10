"""What a campaign will take: timed on its first points, before it starts."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from qzs_rig.campaign.plan import Plan
from qzs_rig.campaign.sampling import LatinHypercube

ENOUGH = 0.05
"""Seconds of work from which a point's share is known well enough to plan by."""


@dataclass(frozen=True)
class Expected:
    """`point_s` seconds a point on one thread here, timed on `timed` points; bytes of memory for
    the chunks under way, and of the table on the disk."""

    point_s: float
    timed: int
    memory: int
    table: int


def expected(plan: Plan, chunks_under_way: int) -> Expected:
    """Time growing numbers of points, at most one chunk. Compiling is not counted."""
    count = max(1, plan.chunk // 256)
    _timed(plan, min(count, plan.points))
    while True:
        count = min(count, plan.chunk, plan.points)
        took = _timed(plan, count)
        if took > ENOUGH or count in (plan.chunk, plan.points):
            break
        # toward enough in one step, but not beyond it where the first points were cheap
        count = max(2 * count, int(count * min(ENOUGH / max(took, 1e-6), 64.0)))
    row = 8 * (len(plan.varied) + len(plan.task.outputs)) + 4
    held = 8 * plan.points * (1 + _permutations(plan))  # one column at a time in the summary
    return Expected(
        took / count, count, held + 2 * row * plan.chunk * chunks_under_way, row * plan.points
    )


def _timed(plan: Plan, count: int) -> float:
    began = time.perf_counter()
    with np.errstate(all='ignore'):
        plan.task.evaluate(plan.between(0, count), plan.options)
    return time.perf_counter() - began


def _permutations(plan: Plan) -> int:
    return len(plan.varied) if isinstance(plan.sample, LatinHypercube) else 0
