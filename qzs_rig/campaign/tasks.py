"""The tasks of campaigns, and here those of the platform: its statics, its design, a run of it."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from qzs_rig.campaign.motion_tasks import LYAPUNOV, STROBE
from qzs_rig.campaign.response_tasks import FRF, SINGLE_TERM, TRACE
from qzs_rig.campaign.task import Output, Task, row_by_row
from qzs_rig.design.proposal import Wish, propose
from qzs_rig.errors import InputError
from qzs_rig.mechanics import statics
from qzs_rig.mechanics.platform import platform_design
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.parameters import Parameter, RunSpec, positive
from qzs_rig.run import in_process
from qzs_rig.units import DOFS, QUANTITIES

SPRINGS = ('k1', 'k2', 'k3')
LENGTHS = ('L1', 'L20', 'L0')
WAYS = ('forward', 'reverse')


def at_rest(spec: RunSpec, options: RunSpec, _: int) -> Mapping[str, float]:
    """Eqs (5)-(24) at one point, about 1 ms."""
    law, dof, design = RESTORING[spec.text('platform.law')], spec.text('dof'), platform_design(spec)
    nowhere = (math.nan, math.nan)
    soft = statics.soft_range(law, design, dof, options.number('tolerance')) or nowhere
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


def run(spec: RunSpec, _: RunSpec, seed: int) -> Mapping[str, float]:
    """What the analyzer reads off a run; `seed` is that of the sensor noise, unless run.seed is
    given."""
    if 'run.seed' not in spec.given:
        spec = spec.override({'run.seed': seed})
    dof = spec.text('dof')
    if not spec.number(f'excitation.amplitude.{dof}'):
        raise InputError(f'{dof} is not driven; give excitation.amplitude.{dof}')
    estimate = in_process.run(spec).estimate
    curves = [curve for curve in estimate.curves if curve.dof == dof and curve.magnitude.size]
    if not curves:
        raise InputError(f'the run gave no curve of {dof}; lengthen it or see analyzer.dofs')
    best = max(curves, key=lambda curve: float(curve.magnitude.max()))
    events = {(e.kind, e.direction): e.frequency_hz for e in estimate.events if e.dof == dof}
    jumps = {kind: frequency for (kind, _), frequency in events.items()}
    streams = estimate.quality.get('streams', {})
    return {
        'peak_T': float(best.magnitude.max()),
        'peak_hz': float(best.frequency_hz[best.magnitude.argmax()]),
        **{f'onset_{way}_hz': events.get(('onset', way), math.nan) for way in WAYS},
        'jump_down_hz': jumps.get('jump_down', math.nan),
        'jump_up_hz': jumps.get('jump_up', math.nan),
        'lost': float(sum(counts['lost'] for counts in streams.values())),
    }


def proposed(spec: RunSpec, *_: object) -> Mapping[str, float]:
    """The platform for one wish, about 20 ms; a wish that cannot be had is a failed row."""
    mass, onset, stroke, level, zeta = (
        spec.number(name) for name in ('mass', 'onset', 'stroke', 'level', 'zeta')
    )
    found = propose(Wish(mass, onset, stroke, level, spec.text('held'), zeta))
    response = found.motion.response()
    read = {
        'onset_hz': response.onset,
        'peak_T': response.peak_height,
        'relative': response.relative,
    }
    return {
        **{name: float(getattr(found, name)) for name in (*SPRINGS, *LENGTHS)},
        **{name: math.nan if value is None else value for name, value in read.items()},
    }


def _positive(name: str, default: float | None, unit: str, text: str) -> Parameter:
    return positive(name, default, unit, text)


STATICS = Task(
    name='statics',
    text='stiffness at the working point, soft range, load capacity, QZS conditions',
    inputs=(Parameter('dof', str, 'vertical', '', 'degree of freedom', choices=DOFS),),
    needed=(),
    options=(_positive('tolerance', 0.05, '', 'stiffness over k1 that counts as quasi-zero'),),
    outputs=(
        Output('stiffness', '', 'stiffness at the working point over k1 (k1 L20 L0 for rotations)'),
        Output('soft_low', '', 'lower end of the range of quasi-zero stiffness, over L20 or rad'),
        Output('soft_high', '', 'its upper end; NaN: not soft at the working point'),
        Output('static_load', '', 'payload that the vertical law carries, over k1 L20'),
        Output('load_saturation', '', 'where the load capacity (24) ends, over k1 L20'),
        Output('qzs_residual', '', 'condition (16): 1 + A - A/a + k3_hat, zero where it holds'),
        Output('tipping_margin', '', 'condition (19): k3_hat - A L0_hat, negative where it tips'),
    ),
    chunk=256,
    compute=row_by_row(at_rest),
)
RUN = Task(
    name='run',
    text='a whole run of the rig: peak, onset and jumps as its analyzer reads them',
    inputs=(Parameter('dof', str, 'vertical', '', 'motion whose curve is read', choices=DOFS),),
    needed=(),
    options=(),
    outputs=(
        Output('peak_T', '', 'largest measured T'),
        Output('peak_hz', 'Hz', 'where'),
        *(Output(f'onset_{way}_hz', 'Hz', f'isolation onset, {way} sweep') for way in WAYS),
        Output('jump_down_hz', 'Hz', 'NaN: none seen'),
        Output('jump_up_hz', 'Hz', 'NaN: none seen'),
        Output('lost', 'samples', 'lost on either sensor; a run in process loses none'),
    ),
    chunk=4,
    compute=row_by_row(run),
)
DESIGN = Task(
    name='design',
    text='the platform that qzs-rig design proposes for a wish',
    inputs=(
        _positive('mass', None, 'kg', 'payload'),
        _positive('onset', None, 'Hz', 'it shall isolate above this frequency'),
        _positive('stroke', None, 'm', 'largest relative motion, to either side'),
        _positive('level', None, 'm/s² or m', 'amplitude of the base, in the unit of held'),
        _positive('zeta', 0.1, '', 'damping ratio'),
        Parameter(
            'held',
            str,
            'acceleration',
            '',
            'what the base holds over frequency',
            choices=QUANTITIES,
        ),
    ),
    needed=(('mass',), ('onset',), ('stroke',), ('level',)),
    options=(),
    outputs=(
        *(Output(name, 'N/m', 'spring rate, all in all') for name in SPRINGS),
        *(Output(name, 'm', 'length') for name in LENGTHS),
        Output('onset_hz', 'Hz', 'onset that one-term theory gives'),
        Output('peak_T', '', 'largest T; NaN: nowhere above 1'),
        Output('relative', 'm', 'largest relative motion'),
    ),
    chunk=32,
    compute=row_by_row(proposed),
)

TASKS = {
    task.name: task for task in (STATICS, SINGLE_TERM, FRF, TRACE, STROBE, LYAPUNOV, RUN, DESIGN)
}
"""By the name that a plan gives."""
