"""One branch of the frequency response at each point: the one that a sweep begins on."""

from __future__ import annotations

from collections.abc import Mapping

from qzs_rig.campaign.oscillators import AMPLITUDE_NEEDED, MOTION, oscillator_of
from qzs_rig.campaign.task import Output, Part, Points, Task, row_by_row
from qzs_rig.campaign.tasks.frf import answer
from qzs_rig.mechanics.platform import refuse_coupled
from qzs_rig.parameters import Parameter, RunSpec
from qzs_rig.theory.balance.response import least_branch

OPTIONS = (
    Parameter('low', float, 0.05, '', 'lowest Ω', 0.0, above=True),
    Parameter('high', float, 2.0, '', 'highest Ω', 0.0, above=True),
    Parameter('harmonics', int, 15, '', 'in all motions', 1, 100),
    Parameter('direction', str, 'down', '', 'where the branch begins', choices=('down', 'up')),
)
OUTPUTS = (
    Output('peak_T', '', 'largest T of stable motion on the branch'),
    Output('peak_omega', '', 'Ω of the peak'),
    Output('onset_omega', '', 'highest Ω where T of stable motion falls below 1; NaN: nowhere'),
    Output('fold_low', '', 'lowest fold; NaN: nothing jumps'),
    Output('fold_high', '', 'highest fold'),
    Output('folds', '', 'how many'),
    Output('complete', '', '1, or 0 where the branch ended early'),
)


def evaluate(points: Points, options: RunSpec) -> Part:
    """Each point by itself."""

    def row(spec: RunSpec, _: int) -> Mapping[str, float]:
        refuse_coupled(spec)
        found = least_branch(
            oscillator_of(spec),
            options.number('low'),
            options.number('high'),
            options.text('direction'),
            options.count('harmonics'),
        )
        figures = answer(found)
        return {output.name: figures[output.name] for output in OUTPUTS}

    return row_by_row(points, TASK.columns, row)


TASK = Task(
    name='trace',
    text='one branch of the frequency response: peak, onset, folds',
    inputs=MOTION,
    needed=(AMPLITUDE_NEEDED,),
    options=OPTIONS,
    outputs=OUTPUTS,
    chunk=16,
    evaluate=evaluate,
)
