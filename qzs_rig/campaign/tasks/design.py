"""A platform proposed at each point: springs, lengths and response for a wish."""

from __future__ import annotations

import math
from collections.abc import Mapping

from qzs_rig.campaign.task import Output, Part, Points, Task, row_by_row
from qzs_rig.design.proposal import Wish, propose
from qzs_rig.parameters import Parameter, RunSpec
from qzs_rig.units import QUANTITIES


def _wish(name: str, default: float | None, unit: str, text: str) -> Parameter:
    return Parameter(name, float, default, unit, text, 0.0, above=True)


INPUTS = (
    _wish('mass', None, 'kg', 'payload'),
    _wish('onset', None, 'Hz', 'it shall isolate above this frequency'),
    _wish('stroke', None, 'm', 'largest relative motion, to either side'),
    _wish('level', None, 'm/s² or m', 'amplitude of the base, in the unit of held'),
    _wish('zeta', 0.1, '', 'damping ratio'),
    Parameter(
        'held', str, 'acceleration', '', 'what the base holds over frequency', choices=QUANTITIES
    ),
)
SPRINGS = ('k1', 'k2', 'k3')
LENGTHS = ('L1', 'L20', 'L0')
OUTPUTS = (
    *(Output(name, 'N/m', 'spring rate, all in all') for name in SPRINGS),
    *(Output(name, 'm', 'length') for name in LENGTHS),
    Output('onset_hz', 'Hz', 'onset that one-term theory gives'),
    Output('peak_T', '', 'largest T; NaN: nowhere above 1'),
    Output('relative', 'm', 'largest relative motion'),
)


def evaluate(points: Points, options: RunSpec) -> Part:
    """Each point by itself, about 20 ms; a wish that cannot be had is a failed row."""
    return row_by_row(points, TASK.columns, answer)


def answer(spec: RunSpec, _: int) -> Mapping[str, float]:
    """The outputs of one wish."""
    mass, onset, stroke, level, zeta = (
        spec.number(name) for name in ('mass', 'onset', 'stroke', 'level', 'zeta')
    )
    found = propose(Wish(mass, onset, stroke, level, spec.text('held'), zeta))
    response = found.motion.response()
    told = {
        'onset_hz': response.onset,
        'peak_T': response.peak_height,
        'relative': response.relative,
    }
    return {
        **{name: float(getattr(found, name)) for name in (*SPRINGS, *LENGTHS)},
        **{name: math.nan if value is None else value for name, value in told.items()},
    }


TASK = Task(
    name='design',
    text='the platform that qzs-rig design proposes for a wish',
    inputs=INPUTS,
    needed=(('mass',), ('onset',), ('stroke',), ('level',)),
    options=(),
    outputs=OUTPUTS,
    chunk=32,
    evaluate=evaluate,
)
