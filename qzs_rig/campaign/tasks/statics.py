"""Statics at each point: stiffness at the working point, soft range, load. Eqs (5)-(24)."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from qzs_rig.campaign.task import Output, Part, Points, Task, row_by_row
from qzs_rig.mechanics import statics
from qzs_rig.mechanics.platform import platform_design
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.parameters import Parameter, RunSpec
from qzs_rig.units import DOFS

INPUTS = (Parameter('dof', str, 'vertical', '', 'degree of freedom', choices=DOFS),)
OPTIONS = (
    Parameter(
        'tolerance', float, 0.05, '', 'stiffness over k1 that counts as quasi-zero', 0.0, above=True
    ),
)
OUTPUTS = (
    Output('stiffness', '', 'stiffness at the working point over k1 (k1 L20 L0 for rotations)'),
    Output('soft_low', '', 'lower end of the range of quasi-zero stiffness, over L20 or rad'),
    Output('soft_high', '', 'its upper end; NaN: not soft at the working point'),
    Output('static_load', '', 'payload that the vertical law carries, over k1 L20'),
    Output('load_saturation', '', 'where the load capacity (24) ends, over k1 L20'),
    Output('qzs_residual', '', 'condition (16): 1 + A - A/a + k3_hat, zero where it holds'),
    Output('tipping_margin', '', 'condition (19): k3_hat - A L0_hat, negative where it tips'),
)


def evaluate(points: Points, options: RunSpec) -> Part:
    """Each point by itself, about 1 ms."""

    def row(spec: RunSpec, _: int) -> Mapping[str, float]:
        return answer(spec, options.number('tolerance'))

    return row_by_row(points, TASK.columns, row)


def answer(spec: RunSpec, tolerance: float) -> dict[str, float]:
    """The outputs of one point."""
    law, dof, design = RESTORING[spec.text('platform.law')], spec.text('dof'), platform_design(spec)
    soft = statics.soft_range(law, design, dof, tolerance) or (math.nan, math.nan)
    held = statics.conditions(design)
    return {
        'stiffness': float(statics.curve(law, design, dof, np.zeros(1)).stiffness[0]),
        'soft_low': soft[0],
        'soft_high': soft[1],
        'static_load': law.static_load(design)[0],
        'load_saturation': statics.saturated_load(design),
        'qzs_residual': held.vertical,
        'tipping_margin': held.horizontal_rotation,
    }


TASK = Task(
    name='statics',
    text='stiffness at the working point, soft range, load capacity, QZS conditions',
    inputs=INPUTS,
    needed=(),
    options=OPTIONS,
    outputs=OUTPUTS,
    chunk=256,
    evaluate=evaluate,
)
