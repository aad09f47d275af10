"""One run step by step: its time history between the flashes of the stroboscope."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from qzs_rig.errors import InputError
from qzs_rig.mechanics.design import Design
from qzs_rig.mechanics.restoring.roots import rsqrt
from qzs_rig.samples import Array
from qzs_rig.theory.motion.lanes import Lanes
from qzs_rig.theory.motion.splitting import DRIFTS, STAGES, kick_cosines, kick_weights


@dataclass(frozen=True)
class History:
    """Relative motion `w` and velocity dw/dτ at `tau`, each (periods · steps + 1,)."""

    tau: Array
    w: Array
    velocity: Array


def history(run: Lanes, periods: int, steps: int, phase: float = 0.0) -> History:
    """The first of `run` over `periods`, the same numbers as `strobe` gives once a period.

    NaN from where it leaves its law's domain.
    """
    if periods < 1 or steps < 1:
        raise InputError(f'{periods} periods of {steps} steps; give 1 or more of both')
    zeta, drive, omega, load, w, v = run.table[:, 0].tolist()
    design = Design(*(run.design if run.shared else run.design[:, 0]).tolist())
    force = run.law.around(rsqrt)[run.number]
    h = 2.0 * np.pi / (omega * steps)
    decay = np.exp(-2.0 * zeta * DRIFTS * h).tolist()
    reach = (-np.expm1(-2.0 * zeta * DRIFTS * h) / (2.0 * zeta) if zeta else DRIFTS * h).tolist()
    # the last kick of a step is its own, so that the velocity stands at the same time as w
    weights = (h * kick_weights(1)).tolist()
    pushes = drive * kick_cosines(steps, phase) + load
    stages = list(zip(reach, decay, weights[1:], strict=True))
    out = np.full((periods * steps + 1, 2), np.nan)
    out[0] = w, v
    try:
        for k in range(periods * steps):
            push = pushes[k % steps * STAGES :][: STAGES + 1].tolist()
            v += weights[0] * (push[0] - force(design, w))
            for (far, left, weight), pushed in zip(stages, push[1:], strict=True):
                w += far * v
                v = left * v + weight * (pushed - force(design, w))
            out[k + 1] = w, v
    except (ValueError, OverflowError, ZeroDivisionError):
        pass  # out of the domain: what is not filled is NaN
    return History(h * np.arange(len(out)), out[:, 0], out[:, 1])
