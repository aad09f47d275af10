"""Runs along one parameter: a ratio of theory, or a word of the platform in SI."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from qzs_rig.errors import InputError
from qzs_rig.mechanics.platform import Platform
from qzs_rig.parameters import RunSpec
from qzs_rig.samples import Array
from qzs_rig.theory.motion.lanes import Lanes
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import DOFS, TRANSLATIONS

RATIOS = ('zeta', 'amplitude', 'omega', 'load')
"""Vary alone: everything else nondimensional stays."""

SLANT = 'L20'
"""Length of the suspension springs with L1/L20 held, so that a stays; L0 is held in m."""


def lanes_along(
    spec: RunSpec, oscillator: Oscillator, omega: float, name: str, values: Array
) -> Lanes:
    """A run of `oscillator`, the one of `spec`, at `omega` for each of `values` of `name`.

    RATIOS replace their own. `L20` or any `platform.…` word changes the platform: springs, base
    amplitude in m and frequency in rad/s stay what they are, and all ratios follow.
    """
    if name in RATIOS:
        told: dict[str, Any] = {'omega': omega} | {name: values}
        return Lanes.of(oscillator, **told)
    word = 'platform.L20' if name == SLANT else name
    if not word.startswith('platform.'):
        raise InputError(
            f'unknown parameter {name!r}; vary one of {", ".join(RATIOS)}, {SLANT} or '
            'platform.…, which qzs-rig scenarios --parameters lists'
        )
    k = DOFS.index(oscillator.dof)
    own = Platform.from_spec(spec)
    held = {'platform.L1_hat': own.design.L1} if name == SLANT else {}
    rigs = [Platform.from_spec(spec.override({**held, word: v})) for v in values.tolist()]
    reach = oscillator.dof in TRANSLATIONS
    scale = np.array([own.length[k] / rig.length[k] if reach else 1.0 for rig in rigs])
    speed = np.array([own.omega0[k] / rig.omega0[k] for rig in rigs])
    # a damping ratio that was told stays; what the platform says follows the platform
    told_zeta = not math.isclose(oscillator.zeta, own.zeta[k], rel_tol=1e-12)
    return Lanes.of(
        oscillator,
        omega * speed,
        zeta=oscillator.zeta if told_zeta else np.array([rig.zeta[k] for rig in rigs]),
        amplitude=oscillator.amplitude * scale,
        load=np.array([rig.load[k] for rig in rigs]),
        designs=[rig.design for rig in rigs],
    )
