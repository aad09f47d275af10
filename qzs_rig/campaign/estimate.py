"""What a campaign will take: timed on some of its points, before it starts."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from qzs_rig.campaign.plan import Plan
from qzs_rig.campaign.sampling import LatinHypercube

ENOUGH = 0.05
"""Seconds of work from which a point's share is known well enough to plan by."""
SPOTS = 8
"""Places in the campaign at which points are timed: those at its start may be slow or quick."""
GROWTH = 8


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
    most = min(plan.chunk, plan.points)
    count = min(plan.task.block, most)
    _timed(plan, count)  # a kernel is compiled, or taken from the disk
    took = _timed(plan, count)
    while took < ENOUGH and count < most:
        count = min(GROWTH * count, most)
        took = _timed(plan, count)
    row = 8 * (len(plan.varied) + len(plan.task.outputs)) + 4
    held = 8 * plan.points * (1 + _permutations(plan))  # one column at a time in the summary
    return Expected(
        took / count, count, held + 2 * row * plan.chunk * chunks_under_way, row * plan.points
    )


def _timed(plan: Plan, count: int) -> float:
    """Seconds for `count` points, in equal parts from all over the campaign."""
    spots = max(1, min(SPOTS, count // plan.task.block))
    each = np.diff(np.linspace(0, count, spots + 1).astype(int)).tolist()
    began = time.perf_counter()
    for spot, size in enumerate(each):
        first = (2 * spot + 1) * (plan.points - size) // (2 * spots)
        with np.errstate(all='ignore'):
            plan.task.evaluate(plan.between(first, first + size), plan.options)
    return time.perf_counter() - began


def _permutations(plan: Plan) -> int:
    return len(plan.varied) if isinstance(plan.sample, LatinHypercube) else 0
