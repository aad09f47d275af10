"""The stroboscope's kernel for a law: compiled where numba is installed, else numpy's."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache, partial
from itertools import pairwise
from typing import Any

import numpy as np

from qzs_rig.mechanics import specialise
from qzs_rig.mechanics.restoring.law import RestoringLaw
from qzs_rig.mechanics.restoring.roots import fast_rsqrt, reciprocal, teach_numba
from qzs_rig.theory.motion import strobe_cycles, strobe_numpy
from qzs_rig.theory.motion import strobe_kernel as source

FAST = {'contract', 'reassoc', 'arcp', 'afn', 'nsz'}
"""Arithmetic that may be regrouped; numbers that are not finite stay what they are."""


@cache
def sweeping(law: RestoringLaw, number: int, shared: bool) -> Callable[..., None]:
    """`strobe_kernel.sweep` around the force of a degree of freedom."""
    try:
        return partial(_sweep(shared), advancing(source.advance, law, number, shared))
    except ImportError:
        plain = strobe_numpy.advancing(law.around(reciprocal(np.sqrt))[number])
        take = source.keep_shared if shared else source.take_own
        return partial(specialise.interpreted(source.sweep, {'take': take}), plain)


def advancing(template: Any, law: RestoringLaw, number: int, shared: bool) -> Any:
    """An `advance` compiled around a force, to be passed as a pointer: what it is passed to is
    compiled once for all laws. Raises ImportError where numba is missing."""
    teach_numba()
    at = source.shared if shared else source.each
    formulas = {'force': law.around(fast_rsqrt)[number], 'at': at}
    return specialise.compiled(template, formulas, fastmath=FAST, signature=advance_type(shared))


def advance_type(shared: bool) -> Any:
    """numba's type of both `advance`."""
    from numba import float64, types, void

    # numba's own types carry no annotations
    pack: Any = types.UniTuple
    line, grid = float64[::1], float64[:, ::1]
    block = pack(float64, 6) if shared else grid
    return void(block, grid, grid, grid, line, line, grid)


@cache
def _sweep(shared: bool) -> Callable[..., None]:
    from numba import boolean, float64, int64, types, void

    pack: Any = types.Tuple
    line, grid, cube, whole = float64[::1], float64[:, ::1], float64[:, :, ::1], int64[::1]
    one = advance_type(shared)
    design = one.args[0]
    signature = void(
        types.FunctionType(one),
        pack([grid, cube, grid, grid, line, int64[:, ::1]]),
        design,
        design,
        *(grid, line, line, line, grid),
        *(int64, int64, boolean, float64, float64),
        *(cube, whole, whole, grid),
    )
    names = ('finish', 'board', 'look_back', 'remember', 'lose')
    apart = specialise.compiled(strobe_cycles.apart, {})
    parts: dict[str, Any] = {
        'take': source.keep_shared if shared else source.take_own,
        'returned': specialise.compiled(strobe_cycles.returned, {'apart': apart}),
        **{name: getattr(source, name) for name in names},
    }
    return specialise.compiled(source.sweep, parts, signature=signature)


def tasks(runs: int, workers: int) -> list[slice]:
    """Runs shared out in even parts: lanes stay full, and no worker waits long for another."""
    rounds = min(4, runs // (4 * strobe_cycles.LANES * workers)) if workers > 1 else 0
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
