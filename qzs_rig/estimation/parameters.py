"""What the analyzer can be told: estimator, its settings, and where the signals come from."""

from __future__ import annotations

from dataclasses import fields

from qzs_rig.errors import InputError
from qzs_rig.estimation import ESTIMATORS, TrackedSineSettings, channels
from qzs_rig.estimation.settings import BOUNDS
from qzs_rig.parameters import Parameter, RunSpec
from qzs_rig.units import DOFS

_SETTINGS = {
    'periods': ('', 'length of the analysis window in periods of the base motion'),
    'hop_periods': ('', 'distance between window centres in periods'),
    'harmonics': ('', 'highest harmonic fitted; 1 is the fundamental'),
    'frequency_min': ('Hz', 'lowest tone that is looked for'),
    'frequency_max': ('Hz', 'highest tone that is looked for'),
    'chirp_max': ('Hz/s', 'fastest sweep that is looked for'),
    'floor_acceleration': ('m/s²', 'a translation whose base amplitude is below is not excited'),
    'floor_rate': ('rad/s', 'a rotation whose base amplitude is below is not excited'),
    'residual_max': ('', 'misfit of the base, rms over its fundamental, that drops a window'),
    'settle_tolerance': ('', 'relative change of transmissibility that counts as settled'),
    'settle_periods': ('', 'periods at the end of a plateau over which that must hold'),
    'plateau_tolerance': ('', 'relative change of frequency that still is one plateau'),
}

_DEFAULTS = TrackedSineSettings()

PARAMETERS = (
    Parameter(
        'analyzer.estimator',
        str,
        'tracked_sine',
        '',
        'how transmissibility is estimated; stepped_sine averages settled plateaus',
        choices=tuple(ESTIMATORS),
    ),
    *(
        Parameter(
            f'analyzer.{setting.name}',
            type(getattr(_DEFAULTS, setting.name)),
            getattr(_DEFAULTS, setting.name),
            _SETTINGS[setting.name][0],
            _SETTINGS[setting.name][1],
            *BOUNDS[setting.name],
        )
        for setting in fields(TrackedSineSettings)
    ),
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
    *channels.PARAMETERS,
)


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


def settings_of(spec: RunSpec) -> TrackedSineSettings:
    """The estimator's settings in a RunSpec."""
    names = [setting.name for setting in fields(TrackedSineSettings)]
    return TrackedSineSettings(**{name: spec[f'analyzer.{name}'] for name in names})  # type: ignore[arg-type]
