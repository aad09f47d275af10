"""What a million points of each restoring law cost: shared out to compiled threads, and in numpy.

A point is one value of one degree of freedom; the four are evaluated together, as (n, 4). Ratios
are to plain numpy and to the cubic law `symmetric`, in the same run.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable

import numpy as np

from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import PAPER_DESIGN, RestoringLaw
from qzs_rig.samples import Array

POINTS = 1_000_000


def rate(work: Callable[[], object], repeats: int = 15) -> float:
    """Best of `repeats`, in millions of points a second."""
    best = np.inf
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - begin)
    return POINTS / best / 1e6


def in_numpy(law: RestoringLaw, w: Array) -> Array:
    """What `force` gives without compiled threads."""
    return np.stack([law.along(n)(PAPER_DESIGN, w[:, n]) for n in range(4)], axis=-1)


def main() -> None:
    w = np.random.default_rng(0).uniform(-0.9, 0.9, (POINTS // 4, 4))
    rates = {
        law.name: (
            rate(lambda law=law: law.force(PAPER_DESIGN, w)),
            rate(lambda law=law: in_numpy(law, w)),
        )
        for law in RESTORING.values()
    }
    cubic = rates['symmetric'][0]
    print(f'M points/s, {os.cpu_count()} cores |  force |  numpy | / numpy | symmetric / it')
    for name, (fast, plain) in rates.items():
        print(f'{name:22} | {fast:6.0f} | {plain:6.0f} | {fast / plain:7.2f} | {cubic / fast:6.2f}')


if __name__ == '__main__':
    main()
