"""A whole run of the rig at each point, in this process: what its analyzer reads off."""

from __future__ import annotations

import math
from collections.abc import Mapping

from qzs_rig.campaign.task import Output, Part, Points, Task, row_by_row
from qzs_rig.errors import InputError
from qzs_rig.estimation.estimate import Estimate
from qzs_rig.parameters import Parameter, RunSpec
from qzs_rig.run import in_process
from qzs_rig.units import DOFS

INPUTS = (Parameter('dof', str, 'vertical', '', 'motion whose curve is read', choices=DOFS),)
WAYS = ('forward', 'reverse')
OUTPUTS = (
    Output('peak_T', '', 'largest measured T'),
    Output('peak_hz', 'Hz', 'where'),
    *(Output(f'onset_{way}_hz', 'Hz', f'isolation onset, {way} sweep') for way in WAYS),
    Output('jump_down_hz', 'Hz', 'NaN: none seen'),
    Output('jump_up_hz', 'Hz', 'NaN: none seen'),
    Output('lost', 'samples', 'lost on either sensor; a run in process loses none'),
)


def evaluate(points: Points, options: RunSpec) -> Part:
    """Each point by itself. Sensor noise gets a seed a point, unless run.seed is given."""

    def row(spec: RunSpec, number: int) -> Mapping[str, float]:
        if 'run.seed' not in spec.given:
            spec = spec.override({'run.seed': points.point_seed(number)})
        dof = spec.text('dof')
        if not spec.number(f'excitation.amplitude.{dof}'):
            raise InputError(f'{dof} is not driven; give excitation.amplitude.{dof}')
        return answer(in_process.run(spec).estimate, dof)

    return row_by_row(points, TASK.columns, row)


def answer(estimate: Estimate, dof: str) -> dict[str, float]:
    """The outputs of one run."""
    streams = estimate.quality.get('streams', {})
    curves = [curve for curve in estimate.curves if curve.dof == dof and curve.magnitude.size]
    if not curves:
        raise InputError(f'the run gave no curve of {dof}; lengthen it or see analyzer.dofs')
    best = max(curves, key=lambda curve: float(curve.magnitude.max()))
    events = {(e.kind, e.direction): e.frequency_hz for e in estimate.events if e.dof == dof}
    jumps = {kind: frequency for (kind, _), frequency in events.items()}
    return {
        'peak_T': float(best.magnitude.max()),
        'peak_hz': float(best.frequency_hz[best.magnitude.argmax()]),
        **{f'onset_{way}_hz': events.get(('onset', way), math.nan) for way in WAYS},
        'jump_down_hz': jumps.get('jump_down', math.nan),
        'jump_up_hz': jumps.get('jump_up', math.nan),
        'lost': float(sum(counts['lost'] for counts in streams.values())),
    }


TASK = Task(
    name='run',
    text='a whole run of the rig: peak, onset and jumps as its analyzer reads them',
    inputs=INPUTS,
    needed=(),
    options=(),
    outputs=OUTPUTS,
    chunk=4,
    evaluate=evaluate,
)
