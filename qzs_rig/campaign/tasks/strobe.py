"""Time integration at each point, seen once a period: what the motion settles to."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from qzs_rig.campaign.bank import (
    AMPLITUDE_NEEDED,
    FREQUENCY,
    FREQUENCY_NEEDED,
    MOTION,
    Bank,
    banks,
    omegas,
)
from qzs_rig.campaign.part import Harvest, Part
from qzs_rig.campaign.points import Points
from qzs_rig.campaign.task import Output, Task
from qzs_rig.parameters import Parameter, RunSpec
from qzs_rig.theory.lanes import Lanes
from qzs_rig.theory.stroboscope import RETURN, strobe

START = (
    Parameter('w', float, 0.0, '', 'relative motion over L20 (rad) where the run starts'),
    Parameter('velocity', float, 0.0, '', 'its slope dw/dτ there'),
)
OPTIONS = (
    Parameter('periods', int, 500, '', 'periods of the base, at most', 1),
    Parameter('steps', int, 24, '', 'integration steps a period', 1),
    Parameter('early', bool, True, '', 'end a run where it repeats itself'),
    Parameter(
        'tolerance', float, RETURN, '', 'transient left where a run repeats itself', 0.0, above=True
    ),
)
OUTPUTS = (
    Output('period', '', 'repeats after so many periods of the base; 0: not settled'),
    Output('settled', '', 'periods until that was found'),
    Output('T', '', '|u|/|v| of the fundamentals'),
    Output('phase_deg', 'deg', 'of the top against the base'),
    Output('amplitude', '', 'fundamental of w over L20, rad for rotations'),
    Output('low', '', 'lowest w of the cycle, of the last 32 periods where not settled'),
    Output('high', '', 'highest'),
    Output('w_end', '', 'w where the base is at its highest'),
    Output('velocity_end', '', 'dw/dτ there'),
)
LOST = "the motion left the law's domain"


def evaluate(points: Points, options: RunSpec) -> Part:
    """All points of one law and motion side by side, on this thread."""
    harvest = Harvest(TASK.columns, len(points))
    for bank in banks(points, harvest):
        _run(lanes(points, bank), bank.rows, options, harvest)
    return harvest.part()


def lanes(points: Points, bank: Bank) -> Lanes:
    """The bank's runs."""
    same = (bank.ratios == bank.ratios[:, :1]).all()
    return Lanes(
        law=bank.law,
        dof=bank.dof,
        falloff=0,
        design=bank.ratios[:, 0].copy() if same else bank.ratios,
        zeta=bank.zeta,
        amplitude=bank.amplitude,
        omega=omegas(points, bank),
        load=bank.load,
        w=points.number('w')[bank.rows],
        velocity=points.number('velocity')[bank.rows],
    )


def _run(runs: Lanes, rows: NDArray[np.int64], options: RunSpec, harvest: Harvest) -> None:
    seen = strobe(
        runs,
        steps=options.count('steps'),
        periods=options.count('periods'),
        keep=0,
        early=options.flag('early'),
        tolerance=options.number('tolerance'),
        workers=1,
    )
    ratio = seen.transmissibility
    good = seen.period >= 0
    columns = (
        seen.period,
        seen.settled,
        np.abs(ratio),
        np.degrees(np.angle(ratio)),
        np.abs(seen.fundamental),
        seen.low,
        seen.high,
        *seen.end.T,
    )
    values = {o.name: c[good] for o, c in zip(OUTPUTS, columns, strict=True)}
    harvest.put(rows[good], values)
    harvest.fail(rows[~good], LOST)


TASK = Task(
    name='strobe',
    text='time integration: what the motion settles to, seen once a period',
    inputs=(*MOTION, *FREQUENCY, *START),
    needed=(AMPLITUDE_NEEDED, FREQUENCY_NEEDED),
    options=OPTIONS,
    outputs=OUTPUTS,
    chunk=16384,
    evaluate=evaluate,
)
