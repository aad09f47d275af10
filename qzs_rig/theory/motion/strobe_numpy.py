"""`advance` of both kernels where numba is missing: the same sums, all lanes at once in numpy."""

from __future__ import annotations

from typing import Any

import numpy as np

from qzs_rig.theory.motion.splitting import STAGES
from qzs_rig.theory.motion.tangent_kernel import SHIFT


def advancing(force: Any) -> Any:
    """`advance` around a force that takes arrays."""

    def advance(
        block: Any, moving: Any, decay: Any, reach: Any, weights: Any, cosines: Any, wave: Any
    ) -> None:
        w, y, _, drive, load = moving[:5]
        y += weights[0] * (drive * cosines[0] + load - force(block, w))
        moving[5:7] = 0.0
        moving[7:9] = w
        for k in range(1, len(weights)):
            stage = (k - 1) % STAGES
            w += reach[stage] * y
            y *= decay[stage]
            y += weights[k] * (drive * cosines[k] + load - force(block, w))
            if stage == STAGES - 1:
                moving[5:7] += np.multiply.outer(wave[(k - 1) // STAGES], w)
                moving[7], moving[8] = np.minimum(moving[7], w), np.maximum(moving[8], w)

    return advance


def tangent_advancing(force: Any) -> Any:
    """`tangent_kernel.advance` around a force that takes arrays."""

    def advance(
        block: Any, moving: Any, decay: Any, reach: Any, weights: Any, cosines: Any, tangent: Any
    ) -> None:
        w, y, _, drive, load = moving[:5]
        dw, dy = tangent
        for k in range(len(weights)):
            if k > 0:
                d, r = decay[(k - 1) % STAGES], reach[(k - 1) % STAGES]
                w += r * y
                dw += r * dy
                y *= d
                dy *= d
            y += weights[k] * (drive * cosines[k] + load - force(block, w))
            slope = (force(block, w + SHIFT) - force(block, w - SHIFT)) * (0.5 / SHIFT)
            dy -= weights[k] * slope * dw

    return advance
