"""Where the signals come from: the two Imu topics, and which field of which feeds which degree of
freedom. Any pair of sensors can take part."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from qzs_rig.errors import InputError
from qzs_rig.parameters import Parameter, RunSpec, positive
from qzs_rig.samples import IMU_CHANNELS, Array
from qzs_rig.units import DOFS, TRANSLATIONS

FIELDS = tuple(channel.name for channel in IMU_CHANNELS)
"""Columns of an Imu reading."""

PLATES = ('base', 'top')

_AXIS = {
    'vertical': 'linear_acceleration.z',
    'horizontal': 'linear_acceleration.x',
    'vertical_rotation': 'angular_velocity.z',
    'horizontal_rotation': 'angular_velocity.y',
}

PARAMETERS = (
    Parameter(
        'analyzer.dofs',
        str,
        'all',
        '',
        'degrees of freedom to analyze, comma separated; all: every one that is excited',
    ),
    Parameter('analyzer.base.topic', str, 'base/imu', '', 'Imu on the base plate'),
    Parameter('analyzer.top.topic', str, 'top/imu', '', 'Imu on the top plate'),
    Parameter(
        'analyzer.source',
        str,
        'rig',
        '',
        'rig: follow the run on rig/run; driver: analyze whatever the two topics bring',
        choices=('rig', 'driver'),
    ),
    Parameter(
        'analyzer.qos',
        str,
        'reliable',
        '',
        'what is asked of the Imu topics; sensor_data suits best-effort drivers',
        choices=('reliable', 'sensor_data'),
    ),
    Parameter(
        'analyzer.silence',
        float,
        0.0,
        's',
        'with source driver: close the run after that much silence; 0 waits for ever',
        0.0,
    ),
    *(
        parameter
        for plate in PLATES
        for dof in DOFS
        for parameter in (
            Parameter(
                f'analyzer.{plate}.axis.{dof}',
                str,
                _AXIS[dof],
                '',
                f'field of the {plate} Imu that shows {dof.replace("_", " ")}; '
                'a leading - turns it',
                choices=tuple(
                    sign + field
                    for sign in ('', '-')
                    for field in FIELDS
                    if field.startswith('linear') == (dof in TRANSLATIONS)
                ),
            ),
            positive(
                f'analyzer.{plate}.scale.{dof}',
                1.0,
                'm/s² or rad/s a unit of the field',
                f'factor on that field of the {plate} Imu (9.80665 for a sensor that reports g)',
            ),
        )
    ),
)


@dataclass(frozen=True)
class ChannelMap:
    """Column and signed scale for each degree of freedom of one plate's Imu."""

    columns: tuple[int, ...]
    scales: tuple[float, ...]

    @classmethod
    def from_spec(cls, spec: RunSpec, plate: str) -> ChannelMap:
        """The map of `plate` ('base' or 'top')."""
        axes = [spec.text(f'analyzer.{plate}.axis.{dof}') for dof in DOFS]
        scales = [spec.number(f'analyzer.{plate}.scale.{dof}') for dof in DOFS]
        return cls(
            tuple(FIELDS.index(axis.lstrip('-')) for axis in axes),
            tuple(-s if axis[0] == '-' else s for axis, s in zip(axes, scales, strict=True)),
        )

    def pick(self, readings: Array) -> Array:
        """Imu readings (n, 6) -> (n, 4): m/s² or rad/s of each degree of freedom."""
        return np.asarray(readings[:, list(self.columns)] * np.array(self.scales))


def dofs_of(spec: RunSpec) -> tuple[str, ...]:
    """The degrees of freedom to analyze, in the order of DOFS; raises InputError for others."""
    text = spec.text('analyzer.dofs')
    if text == 'all':
        return DOFS
    wanted = [dof.strip() for dof in text.split(',') if dof.strip()]
    unknown = [dof for dof in wanted if dof not in DOFS]
    if unknown or not wanted:
        raise InputError(
            f'analyzer.dofs names {unknown[0] if unknown else "nothing"!r}; '
            f'known: all, {", ".join(DOFS)}'
        )
    return tuple(dof for dof in DOFS if dof in wanted)
