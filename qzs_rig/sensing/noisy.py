"""A real accelerometer and gyro, first cut: white noise, full scale, ADC steps."""

from __future__ import annotations

import math

import numpy as np

from qzs_rig.parameters import Parameter, RunSpec, positive
from qzs_rig.samples import NS, Array

PARAMETERS = (
    Parameter(
        'sensor.acceleration_noise',
        float,
        1e-3,
        'm/s²/sqrt(Hz)',
        'one-sided noise density of the accelerometer (1e-3 is a good MEMS part)',
        0.0,
    ),
    Parameter(
        'sensor.rate_noise',
        float,
        1e-4,
        'rad/s/sqrt(Hz)',
        'one-sided noise density of the gyro',
        0.0,
    ),
    positive('sensor.acceleration_range', 160.0, 'm/s²', 'full scale, clipped'),
    positive('sensor.rate_range', 35.0, 'rad/s', 'full scale of the gyro'),
    Parameter('sensor.bits', int, 16, '', 'resolution of the converter over +- full scale', 4, 32),
)


class Noisy:
    """Noise, clipping and quantisation on ideal readings; seeded, independent of chunk size."""

    def __init__(self, spec: RunSpec, step_ns: int, seed: tuple[int, ...]) -> None:
        self._generator = np.random.default_rng(seed)
        self._full_scale = np.repeat(
            [spec.number('sensor.rate_range'), spec.number('sensor.acceleration_range')], 3
        )
        density = [spec.number('sensor.rate_noise'), spec.number('sensor.acceleration_noise')]
        # a one-sided density d fills the band up to half the sample rate
        self._sigma = np.repeat(density, 3) * math.sqrt(0.5 * NS / step_ns)
        self._quantum = self._full_scale / 2 ** (spec.count('sensor.bits') - 1)
        self.clipped = 0

    def read(self, ideal: Array) -> Array:
        """Readings (n, 6) for ideal ones (n, 6); counts clipped values in `clipped`."""
        noise = self._generator.standard_normal(ideal.shape)
        steps = np.round((ideal + self._sigma * noise) / self._quantum)
        limit = np.round(self._full_scale / self._quantum)
        self.clipped += int(np.count_nonzero((steps > limit - 1) | (steps < -limit)))
        return np.asarray(np.clip(steps, -limit, limit - 1) * self._quantum)
