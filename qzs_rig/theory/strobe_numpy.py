"""`strobe_kernel.advance` where numba is missing: the same sums, lane by lane in numpy."""

from __future__ import annotations

from typing import Any

import numpy as np

from qzs_rig.theory.splitting import STAGES


def advancing(force: Any) -> Any:
    """`advance` around a force that takes arrays."""

    def advance(
        block: Any, moving: Any, decay: Any, reach: Any, weights: Any, cosines: Any, wave: Any
    ) -> None:
        w, v, h, drive, load = moving[:5]
        v += weights[0] * (drive * cosines[0] + load - h * force(block, w))
        moving[5:7] = 0.0
        moving[7:9] = w
        for k in range(1, len(weights)):
            stage = (k - 1) % STAGES
            w += reach[stage] * v
            v *= decay[stage]
            v += weights[k] * (drive * cosines[k] + load - h * force(block, w))
            if stage == STAGES - 1:
                moving[5:7] += np.multiply.outer(wave[(k - 1) // STAGES], w)
                moving[7], moving[8] = np.minimum(moving[7], w), np.maximum(moving[8], w)

    return advance
