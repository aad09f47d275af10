"""Levenberg-Marquardt with Marquardt's scaling (SIAM J. 11, 1963), for residuals that may end.

A residual of a measured point ends where its branch folds back before the measured frequency.
Such points drop out on the way; a step is judged on the points that both sides have.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from qzs_rig.samples import Array

State = TypeVar('State')
STEPS = 30
TOLERANCE = 1e-9
"""Share of the sum of squares that the last step still promises: far below what one standard
deviation changes it by, 1/(n - p)."""
SHED = 0.25
"""Share of the residuals that one step may lose."""


@dataclass(frozen=True)
class Trial(Generic[State]):
    """Residuals (m,) and their slopes (m, p) at `values` (p,); `good` (m,) are to be counted.
    `state` is whatever the next evaluation starts from."""

    values: Array
    residual: Array
    jacobian: Array
    good: NDArray[np.bool_]
    state: State


Evaluate = Callable[[Array, State], Trial[State]]


def minimise(
    evaluate: Evaluate[State],
    start: Trial[State],
    scale: Array,
    bounded: Callable[[Array], Array],
    tolerance: float = TOLERANCE,
) -> Trial[State]:
    """The trial of least sum of squares near `start`; `bounded` brings values inside bounds.

    It ends once a step promises less than `tolerance` of the sum.
    """
    here, damping = start, 1e-3
    for _ in range(STEPS):
        J, r = here.jacobian[here.good] * scale, here.residual[here.good]
        normal, slope = J.T @ J, J.T @ r
        # a parameter that moves nothing has a row of zeros, and stays
        diagonal = np.diag(normal) + max(1e-12 * float(np.trace(normal)), 1e-30)
        step = -np.linalg.solve(normal + damping * np.diag(diagonal), slope)
        values = bounded(here.values + scale * step)
        step = (values - here.values) / scale
        promised = -float(step @ (2 * slope + normal @ step))
        there = evaluate(values, here.state)
        both = here.good & there.good
        before, after = (float(np.sum(t.residual[both] ** 2)) for t in (here, there))
        enough = np.count_nonzero(both) >= (1 - SHED) * np.count_nonzero(here.good)
        if enough and after < before:
            here, damping = there, max(0.1 * damping, 1e-9)
            if promised <= tolerance * before:
                break
        elif promised <= tolerance * before or damping > 1e9:
            break
        else:
            damping *= 10.0
    return here
