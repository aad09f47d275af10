"""The stroboscope's kernel for a law: compiled where numba is installed, else numpy's."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from itertools import pairwise

import numpy as np

from qzs_rig.mechanics import specialise
from qzs_rig.mechanics.restoring.law import RestoringLaw
from qzs_rig.mechanics.restoring.roots import fast_rsqrt, reciprocal, teach_numba
from qzs_rig.theory import strobe_kernel as source
from qzs_rig.theory.strobe_numpy import advancing

FAST = {'contract', 'reassoc', 'arcp', 'afn', 'nsz'}
"""Arithmetic that may be regrouped; numbers that are not finite stay what they are."""


@cache
def sweeping(law: RestoringLaw, number: int, shared: bool) -> Callable[..., None]:
    """`strobe_kernel.sweep` around the force of a degree of freedom."""
    parts = {
        'take': source.keep_shared if shared else source.take_own,
        **{
            name: getattr(source, name)
            for name in ('finish', 'board', 'look_back', 'remember', 'lose')
        },
    }
    try:
        teach_numba()
        at = source.shared if shared else source.each
        force = law.around(fast_rsqrt)[number]
        advance = specialise.compiled(source.advance, {'force': force, 'at': at}, fastmath=FAST)
        apart = specialise.compiled(source.apart, {})
        returned = specialise.compiled(source.returned, {'apart': apart})
        return specialise.compiled(
            source.sweep, {'advance': advance, 'returned': returned, **parts}
        )
    except ImportError:
        plain = advancing(law.around(reciprocal(np.sqrt))[number])
        return specialise.interpreted(source.sweep, {'advance': plain, **parts})


def tasks(runs: int, workers: int) -> list[slice]:
    """Runs shared out in even parts: lanes stay full, and no worker waits long for another."""
    rounds = min(4, runs // (4 * source.LANES * workers)) if workers > 1 else 0
    parts = workers * rounds or 1
    edges = [round(k * runs / parts) for k in range(parts + 1)]
    return [slice(*pair) for pair in pairwise(edges)]


def spread(work: Callable[[slice], None], runs: int, workers: int | None) -> None:
    """`work` on all runs, by threads: kernels let go of the interpreter's lock."""
    count = workers or os.cpu_count() or 1
    parts: Sequence[slice] = tasks(runs, count)
    if len(parts) == 1:
        work(parts[0])
        return
    with ThreadPoolExecutor(count) as pool:
        list(pool.map(work, parts))
