"""One-term theory at each point: peak, isolation onset, jumps. Eqs (28)-(32)."""

from __future__ import annotations

import math
from collections.abc import Mapping

from qzs_rig.campaign.oscillators import AMPLITUDE_NEEDED, MOTION, oscillator_of
from qzs_rig.campaign.task import Output, Part, Points, Task, row_by_row
from qzs_rig.mechanics.platform import refuse_coupled
from qzs_rig.parameters import Parameter, RunSpec
from qzs_rig.theory.single_term import folds, onset_omega, peak

OUTPUTS = (
    Output('peak_T', '', 'largest T on a stable branch; NaN: T nowhere exceeds 1, or unbounded'),
    Output('peak_omega', '', 'Ω of the peak'),
    Output('onset_omega', '', 'highest Ω where a stable branch crosses T = 1'),
    Output('fold_low', '', 'lowest Ω where two branches meet; NaN: nothing jumps'),
    Output('fold_high', '', 'highest Ω where two branches meet'),
)
OPTIONS = (
    Parameter(
        'falloff',
        int,
        0,
        '',
        'what the base holds over frequency: 0 displacement, 1 velocity, 2 acceleration',
        0,
        2,
    ),
)


def evaluate(points: Points, options: RunSpec) -> Part:
    """Each point by itself, about 2 ms."""

    def row(spec: RunSpec, _: int) -> Mapping[str, float]:
        return answer(spec, options.count('falloff'))

    return row_by_row(points, TASK.columns, row)


def answer(spec: RunSpec, falloff: int) -> dict[str, float]:
    """The outputs of one point."""
    refuse_coupled(spec)
    own = oscillator_of(spec, falloff)
    law = (*own.cubic, own.zeta, own.amplitude, falloff)
    top, onset, edges = peak(*law), onset_omega(*law), folds(*law)
    return {
        'peak_T': top.T if top else math.nan,
        'peak_omega': top.omega if top else math.nan,
        'onset_omega': math.nan if onset is None else onset,
        'fold_low': float(edges[0]) if edges.size else math.nan,
        'fold_high': float(edges[-1]) if edges.size else math.nan,
    }


TASK = Task(
    name='single_term',
    text='one-term theory: peak, isolation onset, jumps',
    inputs=MOTION,
    needed=(AMPLITUDE_NEEDED,),
    options=OPTIONS,
    outputs=OUTPUTS,
    chunk=64,
    evaluate=evaluate,
)
