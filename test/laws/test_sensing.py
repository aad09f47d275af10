"""Sensors: what an ideal one reads on a turning plate, and what a real one adds to it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import welch
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from qzs_rig import scenario
from qzs_rig.estimation.channels import FIELDS, PLATES, ChannelMap
from qzs_rig.samples import IMU_CHANNELS
from qzs_rig.sensing import SENSORS
from qzs_rig.sensing.imu import specific_force_and_rate
from qzs_rig.units import GRAVITY

STEP_NS = 2_000_000
RATE = 1e9 / STEP_NS
QUIET = {'acceleration_noise': 0.0, 'rate_noise': 0.0}
EPS = np.finfo(float).eps


def sensor(kind='noisy', seed=(1, 0), **given):
    spec = scenario.of({f'sensor.{name}': value for name, value in given.items()})
    return SENSORS[kind](spec, STEP_NS, seed)


def motions(n=200):
    return np.random.default_rng(3).uniform(-1, 1, (n, 12))


def test_at_rest_the_sensor_reads_gravity_upward():
    reading = specific_force_and_rate(np.zeros((1, 12)))
    assert reading.tolist() == [[0, 0, 0, 0, 0, GRAVITY]]


def test_a_level_plate_reads_its_accelerations():
    motion = np.zeros((1, 12))
    motion[0, 8:] = 1.5, 2.5, 0.0, 0.0
    assert specific_force_and_rate(motion).tolist() == [[0, 0, 0, 2.5, 0, 1.5 + GRAVITY]]


def test_a_turned_plate_reads_in_its_own_frame():
    """REP 145: specific force a - g and angular velocity, seen from the plate."""
    motion = motions()
    plate = Rotation.from_euler('ZY', motion[:, 2:4])  # capitals: about the plate's own axes
    n = len(motion)
    felt = np.column_stack([motion[:, 9], np.zeros(n), motion[:, 8] + GRAVITY])
    reading = specific_force_and_rate(motion)
    # components of order 10, each a handful of roundings
    assert np.allclose(reading[:, 3:], plate.inv().apply(felt), rtol=0, atol=64 * EPS)
    h = 1e-5
    ahead, behind = (
        Rotation.from_euler('ZY', motion[:, 2:4] + s * h * motion[:, 6:8]) for s in (1, -1)
    )
    # central difference of the attitude: h² / 6 = 2e-11 and eps / h = 2e-11
    turned = (plate.inv() * ahead).as_rotvec() - (plate.inv() * behind).as_rotvec()
    assert np.allclose(reading[:, :3], turned / (2 * h), rtol=0, atol=1e-9)


@pytest.mark.parametrize('turns', [1, 3, 17])
def test_turning_cannot_change_the_size_of_the_force(turns):
    motion = motions()
    motion[:, 2:4] *= turns
    force = specific_force_and_rate(motion)[:, 3:]
    size = np.hypot(motion[:, 9], motion[:, 8] + GRAVITY)
    assert np.allclose(np.linalg.norm(force, axis=1), size, rtol=8 * EPS)


def test_readings_do_not_depend_on_chunks():
    motion = motions(500)
    whole = specific_force_and_rate(motion)
    for chunk in (1, 7, 50):
        pieces = [specific_force_and_rate(motion[k : k + chunk]) for k in range(0, 500, chunk)]
        assert np.vstack(pieces).tobytes() == whole.tobytes()


@pytest.mark.parametrize('kind', SENSORS)
def test_a_sensor_gives_the_same_bits_for_any_chunk_size(kind):
    readings = motions(1000)[:, :6]
    whole = sensor(kind).read(readings)
    for chunk in (1, 7, 50, 1000):
        cut = sensor(kind)
        pieces = [cut.read(readings[k : k + chunk]) for k in range(0, 1000, chunk)]
        assert np.vstack(pieces).tobytes() == whole.tobytes()


@pytest.mark.parametrize('kind', SENSORS)
def test_the_seed_decides(kind):
    readings = motions(50)[:, :6]
    first, again = (sensor(kind, (5, 0)).read(readings) for _ in range(2))
    assert np.array_equal(first, again)
    if kind != 'ideal':
        for other in ((5, 1), (6, 0)):
            assert not np.array_equal(first, sensor(kind, other).read(readings))


def test_an_ideal_sensor_changes_nothing():
    ideal, readings = sensor('ideal'), 1e6 * motions()[:, :6]
    assert ideal.read(readings) is readings
    assert ideal.clipped == 0


@pytest.mark.parametrize(
    ('column', 'name', 'density'), [(1, 'rate_noise', 3e-4), (5, 'acceleration_noise', 2e-3)]
)
def test_noise_has_the_stated_one_sided_density(column, name, density):
    n = 2**16
    read = sensor(bits=32, **{name: density}).read(np.zeros((n, 6)))[:, column]
    segments = 256
    _, power = welch(read, RATE, 'boxcar', n // segments, 0, detrend=False)
    inner = power[1:-1]  # one-sided: the two ends count once
    # an average of exponentials is a chi square with two degrees of freedom each; 1e-6 two-sided
    freedom = 2 * segments * len(inner)
    low, high = chi2.ppf([5e-7, 1 - 5e-7], freedom) / freedom
    assert low < inner.mean() / density**2 < high
    # white: each line by itself, with the confidence shared among them
    low, high = chi2.ppf([5e-7 / len(inner), 1 - 5e-7 / len(inner)], 2 * segments) / 2 / segments
    assert low < inner.min() / density**2
    assert inner.max() / density**2 < high


def test_axes_have_noise_of_their_own():
    read = sensor(bits=32).read(np.zeros((20_000, 6)))
    correlation = np.corrcoef(read.T) - np.eye(6)
    # 1/sqrt(n) = 0.007, six of them
    assert np.abs(correlation).max() < 0.042


@pytest.mark.parametrize('bits', [8, 16])
def test_readings_are_whole_steps_of_the_converter(bits):
    part = sensor(bits=bits, acceleration_range=20.0, rate_range=4.0, **QUIET)
    readings = motions()[:, :6]
    step = np.repeat([4.0, 20.0], 3) / 2 ** (bits - 1)
    got = part.read(readings)
    assert np.array_equal(got / step, np.round(got / step))
    # half a step, and the rounding of the quotient
    assert (np.abs(got - readings) <= step / 2 + 4 * EPS).all()
    assert part.clipped == 0


def test_readings_beyond_full_scale_are_clipped_and_counted():
    part = sensor(bits=8, acceleration_range=10.0, rate_range=1.0, **QUIET)
    readings = np.zeros((4, 6))
    readings[0, 5], readings[1, 3], readings[2, 0] = 11.0, -12.0, 5.0
    readings[3] = -1.0, 0.0, 0.0, -10.0, 0.0, 9.9  # the ends of the scale are readings
    got = part.read(readings)
    assert part.clipped == 3
    # a two's complement converter reaches -full scale, and one step less upward
    assert (got[0, 5], got[1, 3], got[2, 0]) == (10 * 127 / 128, -10.0, 127 / 128)
    assert (got[3, 0], got[3, 3], got[3, 5]) == (-1.0, -10.0, 10 * 127 / 128)
    part.read(readings)
    assert part.clipped == 6


def test_the_analyzer_names_the_columns_of_the_sensor():
    assert tuple(channel.name for channel in IMU_CHANNELS) == FIELDS


@pytest.mark.parametrize('plate', PLATES)
def test_each_degree_of_freedom_is_read_from_its_axis(plate):
    motion = np.zeros((1, 12))
    motion[0, 8:10], motion[0, 6:8] = (1.0, 2.0), (3.0, 4.0)
    picked = ChannelMap.from_spec(scenario.of({}), plate).pick(specific_force_and_rate(motion))
    assert picked.tolist() == [[1.0 + GRAVITY, 2.0, 3.0, 4.0]]


def test_a_foreign_mounting_is_turned_and_scaled():
    spec = scenario.of(
        {
            'analyzer.top.axis.vertical': '-linear_acceleration.x',
            'analyzer.top.scale.vertical': 9.80665,
            'analyzer.top.axis.horizontal_rotation': 'angular_velocity.x',
        }
    )
    picked = ChannelMap.from_spec(spec, 'top').pick(np.arange(1.0, 7.0)[None])
    assert picked.tolist() == [[-4 * 9.80665, 4.0, 3.0, 1.0]]
