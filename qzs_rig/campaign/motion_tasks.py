"""Time integration at each point: what the motion settles to, and whether it is chaos."""

from __future__ import annotations

import numpy as np

from qzs_rig.campaign.oscillators import INPUTS, NEEDED, STEPS, groups, steps_of
from qzs_rig.campaign.task import Harvest, Output, Points, Task
from qzs_rig.parameters import Parameter, RunSpec
from qzs_rig.theory.motion.batch import WIDTH, Batch
from qzs_rig.theory.motion.chaos import BATCHES, exponents
from qzs_rig.theory.motion.stroboscope import Stroboscope, strobe, strobe_within

LOST = "the motion left the law's domain"


def settled(points: Points, options: RunSpec, harvest: Harvest) -> None:
    """The stroboscope, runs side by side on this thread."""
    for rows, runs in groups(points, harvest):
        seen = _seen(runs, options)
        ratio = seen.transmissibility
        columns = {
            'period': seen.period,
            'settled': seen.settled,
            'T': np.abs(ratio),
            'phase_deg': np.degrees(np.angle(ratio)),
            'w_amplitude': np.abs(seen.fundamental),
            'low': seen.low,
            'high': seen.high,
            'w_end': seen.end[:, 0],
            'velocity_end': seen.end[:, 1],
            'steps': np.broadcast_to(seen.steps, len(rows)),
            'error': seen.error,
        }
        good = seen.period >= 0
        harvest.put(rows[good], {name: column[good] for name, column in columns.items()})
        harvest.fail(rows[~good], LOST)


def _seen(runs: Batch, options: RunSpec) -> Stroboscope:
    periods, early = options.count('periods'), options.flag('early')
    if options.flag('checked'):
        error = options.number('error')
        return strobe_within(runs, error, periods=periods, keep=0, early=early, workers=1)
    steps = steps_of(runs, options)
    return strobe(runs, steps=steps, periods=periods, keep=0, early=early, workers=1)


def chaos(points: Points, options: RunSpec, harvest: Harvest) -> None:
    """Largest Lyapunov exponents, runs side by side on this thread."""
    periods, before = options.count('periods'), options.count('before')
    for rows, runs in groups(points, harvest):
        steps = steps_of(runs, options)
        found = exponents(runs, steps=steps, periods=periods, before=before, workers=1)
        columns = {
            'exponent': found.value,
            'uncertainty': found.error,
            'chaotic': found.chaotic,
            'regular': found.regular,
            'steps': np.full(len(rows), steps),
        }
        good = np.isfinite(found.value)
        harvest.put(rows[good], {name: column[good] for name, column in columns.items()})
        harvest.fail(rows[~good], LOST)


STROBE = Task(
    name='strobe',
    text='time integration: what the motion settles to, seen once a period',
    inputs=INPUTS,
    needed=NEEDED,
    options=(
        Parameter('periods', int, 500, '', 'periods of the base, at most', 1),
        Parameter('early', bool, True, '', 'end a run where it repeats itself'),
        *STEPS,
        Parameter(
            'checked',
            bool,
            False,
            '',
            'do every run twice to tell its error, and again where it exceeds `error`',
        ),
    ),
    outputs=(
        Output('period', '', 'repeats after so many periods of the base; 0: not settled'),
        Output('settled', '', 'periods until that was found'),
        Output('T', '', '|u|/|v| of the fundamentals'),
        Output('phase_deg', 'deg', 'of the top against the base'),
        Output('w_amplitude', '', 'fundamental of w over L20, rad for rotations'),
        Output('low', '', 'lowest w at step ends of the cycle, or of the last 32 periods'),
        Output('high', '', 'highest'),
        Output('w_end', '', 'w where the base is at its highest'),
        Output('velocity_end', '', 'dw/dτ there'),
        Output('steps', '', 'steps a period'),
        Output('error', '', 'of w, where checked'),
    ),
    chunk=16384,
    compute=settled,
    block=WIDTH,
)
LYAPUNOV = Task(
    name='lyapunov',
    text='largest Lyapunov exponent: chaos, or a transient that has not died out',
    inputs=INPUTS,
    needed=NEEDED,
    options=(
        Parameter(
            'periods', int, 2000, '', 'periods over which a disturbance is followed', BATCHES
        ),
        Parameter('before', int, 100, '', 'periods before, which are forgotten', 0),
        *STEPS,
    ),
    outputs=(
        Output('exponent', 'omega0', 'largest exponent over τ: above 0 neighbouring runs part'),
        Output('uncertainty', 'omega0', 'its standard error'),
        Output('chaotic', '', '1 where it is above 0 beyond doubt'),
        Output('regular', '', '1 where it is below 0 beyond doubt'),
        Output('steps', '', 'steps a period'),
    ),
    chunk=1024,
    compute=chaos,
    block=WIDTH,
)
