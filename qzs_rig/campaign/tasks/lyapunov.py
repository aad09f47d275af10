"""Largest Lyapunov exponent at each point: is what looks irregular chaos?"""

from __future__ import annotations

import numpy as np

from qzs_rig.campaign.oscillators import INPUTS, LOST, NEEDED, STEPS, groups, steps_of
from qzs_rig.campaign.task import Harvest, Output, Part, Points, Task
from qzs_rig.parameters import Parameter, RunSpec
from qzs_rig.theory.motion.batch import WIDTH
from qzs_rig.theory.motion.chaos import BATCHES, exponents

OPTIONS = (
    Parameter('periods', int, 2000, '', 'periods over which a disturbance is followed', BATCHES),
    Parameter('before', int, 100, '', 'periods before, which are forgotten', 0),
    *STEPS,
)
OUTPUTS = (
    Output('exponent', 'omega0', 'largest exponent over τ: above 0 neighbouring runs part'),
    Output('uncertainty', 'omega0', 'its standard error'),
    Output('chaotic', '', '1 where it is above 0 beyond doubt'),
    Output('regular', '', '1 where it is below 0 beyond doubt'),
    Output('steps', '', 'steps a period'),
)


def evaluate(points: Points, options: RunSpec) -> Part:
    """Runs side by side, on this thread."""
    harvest = Harvest(TASK.columns, len(points))
    periods, before = options.count('periods'), options.count('before')
    for rows, runs in groups(points, harvest):
        steps = steps_of(runs, options)
        found = exponents(runs, steps=steps, periods=periods, before=before, workers=1)
        good = np.isfinite(found.value)
        columns = {
            'exponent': found.value,
            'uncertainty': found.error,
            'chaotic': found.chaotic,
            'regular': found.regular,
            'steps': np.full(len(rows), steps),
        }
        harvest.put(rows[good], {name: column[good] for name, column in columns.items()})
        harvest.fail(rows[~good], LOST)
    return harvest.part()


TASK = Task(
    name='lyapunov',
    text='largest Lyapunov exponent: chaos, or a transient that has not died out',
    inputs=INPUTS,
    needed=NEEDED,
    options=OPTIONS,
    outputs=OUTPUTS,
    chunk=1024,
    evaluate=evaluate,
    block=WIDTH,
)
