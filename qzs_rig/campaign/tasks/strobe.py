"""Time integration at each point, seen once a period: what the motion settles to."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from qzs_rig.campaign.oscillators import INPUTS, LOST, NEEDED, STEPS, groups, steps_of
from qzs_rig.campaign.task import Harvest, Output, Part, Points, Task
from qzs_rig.parameters import Parameter, RunSpec
from qzs_rig.theory.motion.batch import WIDTH, Batch
from qzs_rig.theory.motion.stroboscope import Stroboscope, strobe, strobe_within

OPTIONS = (
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
)
OUTPUTS = (
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
)


def evaluate(points: Points, options: RunSpec) -> Part:
    """Runs side by side, on this thread."""
    harvest = Harvest(TASK.columns, len(points))
    for rows, runs in groups(points, harvest):
        seen = _seen(runs, options)
        good = seen.period >= 0
        harvest.put(rows[good], {name: column[good] for name, column in _columns(seen).items()})
        harvest.fail(rows[~good], LOST)
    return harvest.part()


def _seen(runs: Batch, options: RunSpec) -> Stroboscope:
    periods, early = options.count('periods'), options.flag('early')
    if options.flag('checked'):
        error = options.number('error')
        return strobe_within(runs, error, periods=periods, keep=0, early=early, workers=1)
    steps = steps_of(runs, options)
    return strobe(runs, steps=steps, periods=periods, keep=0, early=early, workers=1)


def _columns(seen: Stroboscope) -> dict[str, NDArray[Any]]:
    ratio = seen.transmissibility
    return {
        'period': seen.period,
        'settled': seen.settled,
        'T': np.abs(ratio),
        'phase_deg': np.degrees(np.angle(ratio)),
        'w_amplitude': np.abs(seen.fundamental),
        'low': seen.low,
        'high': seen.high,
        'w_end': seen.end[:, 0],
        'velocity_end': seen.end[:, 1],
        'steps': np.broadcast_to(seen.steps, len(seen.period)),
        'error': seen.error,
    }


TASK = Task(
    name='strobe',
    text='time integration: what the motion settles to, seen once a period',
    inputs=INPUTS,
    needed=NEEDED,
    options=OPTIONS,
    outputs=OUTPUTS,
    chunk=16384,
    evaluate=evaluate,
    block=WIDTH,
)
