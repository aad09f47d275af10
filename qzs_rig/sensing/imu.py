"""What an inertial sensor bolted to a moving plate reads (REP 145), before its own faults."""

from __future__ import annotations

import numpy as np

from qzs_rig.timehistory import Array, Channel

GRAVITY = 9.80665
"""Standard gravity in m/s² (CGPM 1901)."""

IMU_CHANNELS = (
    *(Channel(f'angular_velocity.{axis}', 'rad/s') for axis in 'xyz'),
    *(Channel(f'linear_acceleration.{axis}', 'm/s²') for axis in 'xyz'),
)


def specific_force_and_rate(motion: Array) -> Array:
    """Readings in the plate's frame at `motion` (n, 12) -> (n, 6): angular velocity in rad/s, then
    specific force in m/s², in the order of IMU_CHANNELS.

    `motion` is position, velocity and acceleration of the four degrees of freedom. The plate is
    turned by yaw (vertical_rotation) about z, then pitch (horizontal_rotation) about its own y.
    At rest and level the sensor reads +g on z.
    """
    yaw, pitch = motion[:, 2], motion[:, 3]
    yaw_rate, pitch_rate = motion[:, 6], motion[:, 7]
    up, across = motion[:, 8] + GRAVITY, motion[:, 9]
    sin_yaw, cos_yaw = np.sin(yaw), np.cos(yaw)
    sin_pitch, cos_pitch = np.sin(pitch), np.cos(pitch)
    ahead = cos_yaw * across
    return np.stack(
        [
            -sin_pitch * yaw_rate,
            pitch_rate,
            cos_pitch * yaw_rate,
            cos_pitch * ahead - sin_pitch * up,
            -sin_yaw * across,
            sin_pitch * ahead + cos_pitch * up,
        ],
        axis=1,
    )
