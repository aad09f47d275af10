"""Time-integrated points: their runs side by side, and with how many steps a period."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from qzs_rig.campaign.bank import (
    AMPLITUDE_NEEDED,
    FREQUENCY,
    FREQUENCY_NEEDED,
    MOTION,
    Bank,
    banks,
    omegas,
)
from qzs_rig.campaign.task import Harvest, Points
from qzs_rig.parameters import Parameter, RunSpec
from qzs_rig.theory.motion.batch import Batch
from qzs_rig.theory.motion.stroboscope import alike, cheapest_steps

INPUTS = (
    *MOTION,
    *FREQUENCY,
    Parameter('w', float, 0.0, '', 'relative motion over L20 (rad) where the run starts'),
    Parameter('velocity', float, 0.0, '', 'its slope dw/dτ there'),
)
NEEDED = (AMPLITUDE_NEEDED, FREQUENCY_NEEDED)
STEPS = (
    Parameter('steps', int, 0, '', 'integration steps a period; 0: as few as keep `error`', 0),
    Parameter('error', float, 1e-6, '', 'of w, when steps are chosen', 0.0, above=True),
)
LOST = "the motion left the law's domain"


def groups(points: Points, harvest: Harvest) -> Iterator[tuple[NDArray[np.int64], Batch]]:
    """The points' rows and runs, those of one law, motion and third of an octave together."""
    for bank in banks(points, harvest):
        runs = batch(points, bank)
        for which in alike(runs):
            yield bank.rows[which], runs[which]


def batch(points: Points, bank: Bank) -> Batch:
    """The runs of a bank."""
    return Batch(
        law=bank.law,
        dof=bank.dof,
        falloff=0,
        design=bank.ratios,
        zeta=bank.zeta,
        amplitude=bank.amplitude,
        omega=omegas(points, bank),
        load=bank.load,
        w=points.number('w')[bank.rows],
        velocity=points.number('velocity')[bank.rows],
    )


def steps_of(runs: Batch, options: RunSpec) -> int:
    """Steps a period: those given, or as few as keep the error in the first periods."""
    return options.count('steps') or cheapest_steps(runs, options.number('error'))
