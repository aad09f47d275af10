"""Points of a campaign as oscillators: one at a time, or all of one law and motion at once."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from qzs_rig.campaign.task import Harvest, Points
from qzs_rig.errors import InputError
from qzs_rig.mechanics.platform import refuse_coupled, unbuildable
from qzs_rig.parameters import Parameter, RunSpec, positive
from qzs_rig.theory.motion.batch import Batch
from qzs_rig.theory.motion.stroboscope import alike, cheapest_steps
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import DOFS

MOTION = (
    Parameter('dof', str, 'vertical', '', 'degree of freedom', choices=DOFS),
    positive('amplitude', None, '', 'base amplitude Ĥ over L20, rotations in rad'),
    positive(
        'displacement',
        None,
        'm or rad',
        'base amplitude, instead of amplitude',
        replaces=('amplitude',),
    ),
)
"""What a point says of the base motion."""
FREQUENCY = (
    positive('omega', None, '', 'frequency Ω over omega0'),
    positive('frequency', None, 'Hz', 'instead of omega', replaces=('omega',)),
)
AMPLITUDE_NEEDED = ('amplitude', 'displacement')
FREQUENCY_NEEDED = ('omega', 'frequency')
INPUTS = (
    *MOTION,
    *FREQUENCY,
    Parameter('w', float, 0.0, '', 'relative motion over L20 (rad) where the run starts'),
    Parameter('velocity', float, 0.0, '', 'its slope dw/dτ there'),
)
NEEDED = (AMPLITUDE_NEEDED, FREQUENCY_NEEDED)
STEPS = (
    Parameter('steps', int, 0, '', 'integration steps a period; 0: as few as keep `error`', 0),
    positive('error', 1e-6, '', 'of w, when steps are chosen'),
)


def oscillator_of(spec: RunSpec, falloff: int = 0) -> Oscillator:
    """The oscillator of a point; of a spec with columns, those of its n points."""
    still = Oscillator.of(spec, spec.text('dof'), 0.0, falloff)
    displacement = spec.optional('displacement')
    if displacement is None:
        return replace(still, amplitude=spec.number('amplitude'))
    return replace(still, amplitude=displacement / still.length)


def groups(points: Points, harvest: Harvest) -> Iterator[tuple[NDArray[np.int64], Batch]]:
    """The points' rows and runs, those of one law, motion and third of an octave together.

    Platforms that cannot be built, or not as one degree of freedom, go to `harvest` as failed.
    """
    good = np.ones(len(points), dtype=bool)
    for where, why in unbuildable(points.columns(np.arange(len(points)))):
        harvest.fail(np.flatnonzero(good & where), why)
        good &= np.logical_not(where)
    for rows, spec in points.alike(np.flatnonzero(good)):
        try:
            refuse_coupled(spec)
            runs = _runs(spec, len(rows))
        except InputError as error:
            harvest.fail(rows, f'InputError: {error}')
            continue
        for which in alike(runs):
            yield rows[which], runs[which]


def _runs(spec: RunSpec, count: int) -> Batch:
    own, frequency = oscillator_of(spec), spec.optional('frequency')
    omega = spec.number('omega') if frequency is None else own.omega(frequency)
    w = np.broadcast_to(spec.number('w'), count)
    return Batch.of(own, omega, w=w, velocity=spec.number('velocity'))


def steps_of(runs: Batch, options: RunSpec) -> int:
    """Steps a period: those given, or as few as keep the error in the first periods."""
    return options.count('steps') or cheapest_steps(runs, options.number('error'))
