"""Runs side by side with a small disturbance each, followed by the variational equation.

The disturbance (δw, δw') obeys δw'' + 2ζ δw' + F'(w) δw = 0 in the same drifts and kicks as w, so
it is the exact derivative of the numerical map, but for F', a central difference good to 1e-9.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from qzs_rig.mechanics.restoring.law import Formula
from qzs_rig.mechanics.restoring.polynomial import cubic_force
from qzs_rig.theory.motion.splitting import STAGES
from qzs_rig.theory.motion.strobe_cycles import LANES
from qzs_rig.theory.motion.strobe_kernel import board, keep_shared, shared

SHIFT = 1e-5
"""Half the base of the difference: SHIFT² F'''/6 and rounding/SHIFT are both about 1e-10."""


# Formulas put in: the law, how a lane finds its design and how it is handed one.
force: Formula = cubic_force
"""F(w), net of the static load: a cubic law's where no other is put in."""
at, take = shared, keep_shared


def advance(
    block: Any, moving: Any, decay: Any, reach: Any, weights: Any, cosines: Any, tangent: Any
) -> None:
    """One period of all lanes, as in strobe_kernel without its sums; `tangent` (2, LANES) δw and
    δw'/h."""
    w, v, drive, load = moving[0], moving[1], moving[3], moving[4]
    dw, dv = tangent[0], tangent[1]
    for k in range(len(weights)):
        c, weight = cosines[k], weights[k]
        d, r = decay[(k - 1) % STAGES], reach[(k - 1) % STAGES]
        for lane in range(LANES):
            x, y, dx, dy = w[lane], v[lane], dw[lane], dv[lane]
            if k > 0:
                x, dx = x + r[lane] * y, dx + r[lane] * dy
                y, dy = d[lane] * y, d[lane] * dy
            design = at(block, lane)
            push = drive[lane] * c + load[lane] - force(design, x)
            slope = (force(design, x + SHIFT) - force(design, x - SHIFT)) * (0.5 / SHIFT)
            w[lane], v[lane] = x, y + weight * push
            dw[lane], dv[lane] = dx, dy - weight * slope * dx


def stretch(
    advance: Any,
    work: Any,
    design: Any,
    block: Any,
    runs: Any,
    drifts: Any,
    weights: Any,
    cosines: Any,
    before: int,
    growth: Any,
    ends: Any,
) -> None:
    """Fill `growth` (n, periods) with what log |δ| gains in every period, after `before` others.

    `runs` as for strobe_kernel.sweep; a run that is lost leaves what is not finite. `ends` (n, 2)
    takes w and w' at the end.
    """
    moving, decay, reach, tangent = work
    n, periods = growth.shape
    for first in range(0, n, LANES):
        for lane in range(LANES):
            run = min(first + lane, n - 1)
            board(lane, run, runs, drifts, moving, decay, reach)
            take(block, design, lane, run)
            tangent[0, lane], tangent[1, lane] = 1.0, 0.0
        for period in range(before + periods):
            advance(block, moving, decay, reach, weights, cosines, tangent)
            for lane in range(LANES):
                size = np.sqrt(tangent[0, lane] ** 2 + tangent[1, lane] ** 2)
                tangent[0, lane] /= size
                tangent[1, lane] /= size
                if period >= before and first + lane < n:
                    growth[first + lane, period - before] = np.log(size)
        for lane in range(min(LANES, n - first)):
            ends[first + lane, 0] = moving[0, lane]
            ends[first + lane, 1] = moving[2, lane] * moving[1, lane]
