"""Frequency responses at each point: one-term, all branches, or the one a sweep begins on."""

from __future__ import annotations

import math

from qzs_rig.campaign.oscillators import AMPLITUDE_NEEDED, MOTION, oscillator_of
from qzs_rig.campaign.task import Output, Task, row_by_row
from qzs_rig.errors import RigError
from qzs_rig.mechanics.platform import refuse_coupled
from qzs_rig.parameters import Parameter, RunSpec, positive
from qzs_rig.theory.balance.coupled_response import response_of
from qzs_rig.theory.balance.frequency_response import FrequencyResponse, least_branch
from qzs_rig.theory.single_term import folds, onset_omega, peak

RANGE = (
    positive('low', 0.05, '', 'lowest Ω'),
    positive('high', 2.0, '', 'highest Ω'),
)
FALLOFF = Parameter(
    'falloff',
    int,
    0,
    '',
    'what the base holds over frequency: 0 displacement, 1 velocity, 2 acceleration',
    0,
    2,
)
READ_OFF = (
    Output('peak_T', '', 'largest T of stable motion'),
    Output('peak_omega', '', 'Ω of the peak'),
    Output('onset_omega', '', 'highest Ω where T of stable motion falls below 1; NaN: nowhere'),
    Output('fold_low', '', 'lowest fold; NaN: nothing jumps'),
    Output('fold_high', '', 'highest fold'),
)
FOLDS = Output('folds', '', 'how many')
COMPLETE = Output('complete', '', '1, or 0 where a branch ended early')


class NoMotionError(RigError):
    """No steady motion was found at a point."""


def single_term(spec: RunSpec, options: RunSpec, _: int) -> dict[str, float]:
    """Eqs (28)-(32) at one point, about 2 ms."""
    refuse_coupled(spec)
    falloff = options.count('falloff')
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


def frf(spec: RunSpec, options: RunSpec, _: int) -> dict[str, float]:
    """All branches of one point; a coupled platform moves in all six degrees of freedom."""
    found = response_of(
        spec,
        oscillator_of(spec, options.count('falloff')),
        options.number('low'),
        options.number('high'),
        harmonics=options.count('harmonics') or None,
        isolas=options.flag('isolas'),
    )
    return read_off(found)


def trace(spec: RunSpec, options: RunSpec, _: int) -> dict[str, float]:
    """The branch of one point that a sweep begins on."""
    refuse_coupled(spec)
    found = least_branch(
        oscillator_of(spec),
        options.number('low'),
        options.number('high'),
        options.text('direction'),
        options.count('harmonics'),
    )
    figures = read_off(found)
    return {name: figures[name] for name in TRACE.columns}


def read_off(found: FrequencyResponse) -> dict[str, float]:
    """The outputs of FRF for one response; raises NoMotionError where it has no branch."""
    if not found.branches:
        raise NoMotionError(found.reason or 'no steady motion was found')
    omega, T = found.peak or (math.nan, math.nan)
    edges = [event.omega for event in found.folds]
    return {
        'peak_T': T,
        'peak_omega': omega,
        'onset_omega': max(found.onset_omega, default=math.nan),
        'fold_low': min(edges, default=math.nan),
        'fold_high': max(edges, default=math.nan),
        'folds': len(edges),
        'doublings': len(found.events) - len(edges),
        'branches': len(found.branches),
        'harmonics': found.harmonics,
        'complete': float(found.reason is None),
    }


SINGLE_TERM = Task(
    name='single_term',
    text='one-term theory: peak, isolation onset, jumps',
    inputs=MOTION,
    needed=(AMPLITUDE_NEEDED,),
    options=(FALLOFF,),
    outputs=(
        Output('peak_T', '', 'largest T of stable motion; NaN: nowhere above 1, or unbounded'),
        *READ_OFF[1:],
    ),
    chunk=64,
    compute=row_by_row(single_term),
)
FRF = Task(
    name='frf',
    text='frequency response by harmonic balance: peak, onset, folds, branches',
    inputs=MOTION,
    needed=(AMPLITUDE_NEEDED,),
    options=(
        *RANGE,
        Parameter('isolas', bool, True, '', 'look for isolated branches too'),
        Parameter('harmonics', int, 0, '', 'in all motions; 0: as many as each needs', 0, 200),
        FALLOFF,
    ),
    outputs=(
        *READ_OFF,
        FOLDS,
        Output('doublings', '', 'period doublings and broken symmetries, how many'),
        Output('branches', '', 'how many, isolated ones included'),
        Output('harmonics', '', 'the most that any motion needed'),
        COMPLETE,
    ),
    chunk=4,
    compute=row_by_row(frf),
)
TRACE = Task(
    name='trace',
    text='one branch of the frequency response: peak, onset, folds',
    inputs=MOTION,
    needed=(AMPLITUDE_NEEDED,),
    options=(
        *RANGE,
        Parameter('harmonics', int, 15, '', 'in all motions', 1, 100),
        Parameter('direction', str, 'down', '', 'where the branch begins', choices=('down', 'up')),
    ),
    outputs=(*READ_OFF, FOLDS, COMPLETE),
    chunk=16,
    compute=row_by_row(trace),
)
