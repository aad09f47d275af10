"""One branch of the frequency response at each point, by compiled kernels: some milliseconds."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from qzs_rig.campaign.bank import AMPLITUDE_NEEDED, MOTION
from qzs_rig.campaign.part import Part, row_by_row
from qzs_rig.campaign.points import Points
from qzs_rig.campaign.task import Output, Task
from qzs_rig.campaign.tasks.single_term import amplitude_hat
from qzs_rig.errors import RigError
from qzs_rig.parameters import Parameter, RunSpec
from qzs_rig.samples import Array
from qzs_rig.theory.balance.harmonic_balance import transmissibility
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.theory.tracer.traced import Traced, trace

OPTIONS = (
    Parameter('low', float, 0.05, '', 'lowest Ω', 0.0, above=True),
    Parameter('high', float, 2.0, '', 'highest Ω', 0.0, above=True),
    Parameter('harmonics', int, 15, '', 'in all motions', 1, 100),
    Parameter('direction', str, 'down', '', 'where the branch begins', choices=('down', 'up')),
)
OUTPUTS = (
    Output('peak_T', '', 'largest T of stable motion among the points of the branch'),
    Output('peak_omega', '', 'Ω of the peak'),
    Output('onset_omega', '', 'highest Ω where T of stable motion falls below 1, interpolated'),
    Output('fold_low', '', 'lowest fold, interpolated; NaN: nothing jumps'),
    Output('fold_high', '', 'highest fold'),
    Output('folds', '', 'how many'),
    Output('complete', '', '1 where the branch reached the other end of the range'),
)


class NoBranchError(RigError):
    """No motion was found to begin with."""


def evaluate(points: Points, options: RunSpec) -> Part:
    """Each point by itself; kernels let go of the interpreter."""

    def row(spec: RunSpec, _: int) -> Mapping[str, float]:
        oscillator = Oscillator.of(spec, spec.text('dof'), amplitude_hat(spec))
        found = trace(
            oscillator,
            options.number('low'),
            options.number('high'),
            harmonics=options.count('harmonics'),
            direction=options.text('direction'),
        )
        return answer(oscillator, found)

    return row_by_row(points, TASK.columns, row)


def answer(oscillator: Oscillator, found: Traced) -> dict[str, float]:
    """The outputs of one branch."""
    if found.omega.size < 3:
        raise NoBranchError(f'no branch: {found.reason}; widen the range or give more harmonics')
    T = np.abs(transmissibility(oscillator, found.omega, found.coefficients))
    stable = np.where(found.stable, T, -math.inf)
    best = int(np.argmax(stable))
    folds = _folds(found)
    return {
        'peak_T': float(T[best]) if found.stable[best] else math.nan,
        'peak_omega': float(found.omega[best]) if found.stable[best] else math.nan,
        'onset_omega': _onset(found, T),
        'fold_low': min(folds, default=math.nan),
        'fold_high': max(folds, default=math.nan),
        'folds': len(folds),
        'complete': float(found.reason.startswith('reached')),
    }


def _onset(found: Traced, T: Array) -> float:
    above, omega = T > 1.0, found.omega
    rising = np.diff(omega) > 0.0
    down = np.where(rising, above[:-1] & ~above[1:], ~above[:-1] & above[1:])
    places = np.flatnonzero(down & found.stable[:-1] & found.stable[1:])
    share = (1.0 - T[places]) / (T[places + 1] - T[places])
    crossings = omega[places] + share * (omega[places + 1] - omega[places])
    return float(crossings.max(initial=-math.inf)) if places.size else math.nan


def _folds(found: Traced) -> list[float]:
    """Where Ω turns: vertices of parabolas over the length of the path."""
    omega = found.omega
    turns = np.flatnonzero(np.diff(np.sign(np.diff(omega)))) + 1
    path = np.column_stack([omega, found.coefficients])
    vertices = []
    for k in turns:
        back, ahead = (float(np.linalg.norm(path[k + side] - path[k])) for side in (-1, 1))
        bend, slope, value = np.polyfit([-back, 0.0, ahead], omega[k - 1 : k + 2], 2)
        vertices.append(float(value - slope * slope / (4.0 * bend)))
    return vertices


TASK = Task(
    name='trace',
    text='one branch of the frequency response, compiled: peak, onset, folds',
    inputs=MOTION,
    needed=(AMPLITUDE_NEEDED,),
    options=OPTIONS,
    outputs=OUTPUTS,
    chunk=128,
    evaluate=evaluate,
)
