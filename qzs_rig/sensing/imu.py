"""What an inertial sensor bolted to a moving plate reads (REP 145), before its own faults."""

from __future__ import annotations

import numpy as np

from qzs_rig.samples import Array
from qzs_rig.units import GRAVITY


def specific_force_and_rate(motion: Array) -> Array:
    """Readings in the plate's frame at `motion` (n, 12) -> (n, 6): angular velocity in rad/s, then
    specific force in m/s², in the order of IMU_CHANNELS.

    `motion` is position, velocity and acceleration of the four degrees of freedom. The plate is
    turned by yaw (vertical_rotation) about z, then pitch (horizontal_rotation) about its own y.
    At rest and level the sensor reads +g on z. A coupled plate's motion is (n, 18): then follow
    y and the roll about the plate's own x, both with velocity and acceleration.
    """
    yaw, pitch = motion[:, 2], motion[:, 3]
    yaw_rate, pitch_rate = motion[:, 6], motion[:, 7]
    up, across = motion[:, 8] + GRAVITY, motion[:, 9]
    sin_yaw, cos_yaw = np.sin(yaw), np.cos(yaw)
    sin_pitch, cos_pitch = np.sin(pitch), np.cos(pitch)
    ahead = cos_yaw * across
    aside = -sin_yaw * across
    if motion.shape[1] == 18:
        ahead, aside = ahead + sin_yaw * motion[:, 16], aside + cos_yaw * motion[:, 16]
    reading: Array = np.stack(
        [
            -sin_pitch * yaw_rate,
            pitch_rate,
            cos_pitch * yaw_rate,
            cos_pitch * ahead - sin_pitch * up,
            aside,
            sin_pitch * ahead + cos_pitch * up,
        ],
        axis=1,
    )
    if motion.shape[1] == 18:
        return _rolled(reading, motion[:, 13], motion[:, 15])
    return reading


def _rolled(reading: Array, roll: Array, roll_rate: Array) -> Array:
    sine, cosine = np.sin(roll), np.cos(roll)
    turned: Array = reading.copy()
    for y, z in ((1, 2), (4, 5)):
        turned[:, y] = cosine * reading[:, y] + sine * reading[:, z]
        turned[:, z] = cosine * reading[:, z] - sine * reading[:, y]
    turned[:, 0] += roll_rate
    return turned
