"""The frequency response at each point by harmonic balance: all branches, with stability."""

from __future__ import annotations

import math
from collections.abc import Mapping

from qzs_rig.campaign.oscillators import AMPLITUDE_NEEDED, MOTION, oscillator_of
from qzs_rig.campaign.task import Output, Part, Points, Task, row_by_row
from qzs_rig.errors import RigError
from qzs_rig.parameters import Parameter, RunSpec
from qzs_rig.theory.balance.response import FrequencyResponse
from qzs_rig.theory.coupled.coupled_response import response_of

OPTIONS = (
    Parameter('low', float, 0.05, '', 'lowest Ω', 0.0, above=True),
    Parameter('high', float, 2.0, '', 'highest Ω', 0.0, above=True),
    Parameter('isolas', bool, True, '', 'look for isolated branches too'),
    Parameter('harmonics', int, 0, '', 'in all motions; 0: as many as each needs', 0, 200),
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
OUTPUTS = (
    Output('peak_T', '', 'largest T on a stable branch within the range'),
    Output('peak_omega', '', 'Ω of the peak'),
    Output('onset_omega', '', 'highest Ω where T of stable motion falls below 1; NaN: nowhere'),
    Output('fold_low', '', 'lowest fold; NaN: nothing jumps'),
    Output('fold_high', '', 'highest fold'),
    Output('folds', '', 'how many'),
    Output('doublings', '', 'period doublings and broken symmetries, how many'),
    Output('branches', '', 'how many, isolated ones included'),
    Output('harmonics', '', 'the most that any motion needed'),
    Output('complete', '', '1, or 0 where a branch ended early'),
)


class NoMotionError(RigError):
    """No steady motion was found at a point."""


def evaluate(points: Points, options: RunSpec) -> Part:
    """Each point by itself; a coupled platform in all six degrees of freedom."""

    def row(spec: RunSpec, _: int) -> Mapping[str, float]:
        found = response_of(
            spec,
            oscillator_of(spec, options.count('falloff')),
            options.number('low'),
            options.number('high'),
            harmonics=options.count('harmonics') or None,
            isolas=options.flag('isolas'),
        )
        return answer(found)

    return row_by_row(points, TASK.columns, row)


def answer(found: FrequencyResponse) -> dict[str, float]:
    """The outputs of one response."""
    if not found.branches:
        raise NoMotionError(found.reason or 'no steady motion was found')
    omega, T = found.peak or (math.nan, math.nan)
    folds = [event.omega for event in found.folds]
    return {
        'peak_T': T,
        'peak_omega': omega,
        'onset_omega': max(found.onset_omega, default=math.nan),
        'fold_low': min(folds, default=math.nan),
        'fold_high': max(folds, default=math.nan),
        'folds': len(folds),
        'doublings': len(found.events) - len(folds),
        'branches': len(found.branches),
        'harmonics': found.harmonics,
        'complete': float(found.reason is None),
    }


TASK = Task(
    name='frf',
    text='frequency response by harmonic balance: peak, onset, folds, branches',
    inputs=MOTION,
    needed=(AMPLITUDE_NEEDED,),
    options=OPTIONS,
    outputs=OUTPUTS,
    chunk=4,
    evaluate=evaluate,
)
