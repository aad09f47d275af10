"""What the shaker is asked to do. A new excitation is one file with `PARAMETERS` and `plan`
and one line in EXCITATIONS."""

from __future__ import annotations

from collections.abc import Callable

from qzs_rig.excitation import sine, stepped_sine, sweep
from qzs_rig.excitation.segments import Segment
from qzs_rig.parameters import Parameter, RunSpec, positive
from qzs_rig.units import DOFS, QUANTITIES, TRANSLATIONS

EXCITATIONS: dict[str, Callable[[RunSpec], tuple[Segment, ...]]] = {
    'sine': sine.plan,
    'stepped_sine': stepped_sine.plan,
    'sweep': sweep.plan,
}

PARAMETERS = (
    Parameter(
        'excitation.kind', str, 'sweep', '', 'sort of base motion', choices=tuple(EXCITATIONS)
    ),
    Parameter(
        'excitation.quantity',
        str,
        'acceleration',
        '',
        'quantity whose amplitude is held constant over frequency',
        choices=QUANTITIES,
    ),
    *(
        Parameter(
            f'excitation.amplitude.{dof}',
            float,
            0.0,
            'm, m/s or m/s²' if dof in TRANSLATIONS else 'rad, rad/s or rad/s²',
            f'peak amplitude of the {dof.replace("_", " ")} of the base, in the unit of quantity',
            0.0,
        )
        for dof in DOFS
    ),
    positive('excitation.ramp', 3.0, 's', 'cosine ramp at start and end'),
    positive('excitation.frequency_low', 1.0, 'Hz', 'lower end of the band'),
    positive('excitation.frequency_high', 4.0, 'Hz', 'upper end of the band'),
    positive(
        'excitation.duration',
        114.0,
        's',
        'length of a sine dwell or of a whole sweep, without the ramps',
    ),
    Parameter(
        'excitation.direction',
        str,
        'there_and_back',
        '',
        'way through the band of a sweep or a stepped sine',
        choices=('forward', 'reverse', 'there_and_back'),
    ),
    *sine.PARAMETERS,
    *sweep.PARAMETERS,
    *stepped_sine.PARAMETERS,
)
