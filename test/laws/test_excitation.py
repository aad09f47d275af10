"""The commanded motion: exact derivatives, exact phase, held amplitude, rest at both ends."""

from __future__ import annotations

import math
from decimal import Decimal, localcontext
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from qzs_rig import scenario
from qzs_rig.errors import InputError
from qzs_rig.excitation import EXCITATIONS
from qzs_rig.excitation.drive import Drive, fade_in, fade_out
from qzs_rig.excitation.segments import Dwell, Ease, Glide, LinearChirp, LogChirp
from qzs_rig.run.stages import ExciterStage
from qzs_rig.units import DOFS, QUANTITIES

NS = 1_000_000_000
EPS = np.finfo(float).eps
AMPLITUDE = (0.5, 0.3, 0.2, 0.1)
DIRECTIONS = ('forward', 'reverse', 'there_and_back')
PLANS = list(product(EXCITATIONS, QUANTITIES, DIRECTIONS, ('linear', 'log')))
SHORT = {'duration': 6.0, 'ramp': 1.0, 'steps': 3, 'dwell': 2.0, 'glide': 0.5}

every_plan = pytest.mark.parametrize(('kind', 'quantity', 'direction', 'spacing'), PLANS)


def spec_of(kind='sweep', quantity='displacement', direction='forward', spacing='linear', **more):
    words = {'kind': kind, 'quantity': quantity, 'direction': direction, 'spacing': spacing}
    words |= {f'amplitude.{dof}': a for dof, a in zip(DOFS, AMPLITUDE, strict=True)} | SHORT
    given = {f'excitation.{name}': value for name, value in (words | more).items()}
    return scenario.of({'run.rate': 1000.0, 'shaker.limits': False, **given})


def drive_of(*plan, **more):
    spec = spec_of(*plan, **more)
    return Drive.from_spec(spec, scenario.step_ns_of(spec))


def borders(drive):
    return np.cumsum([segment.duration for segment in drive.segments])[:-1]


def differentiate(values, h):
    """First derivative at the inner samples of (n, c), eighth order, four samples each side."""
    weights = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
    n, total = len(values), 0.0
    for k, weight in enumerate(weights, 1):
        total = total + weight * (values[4 + k : n - 4 + k] - values[4 - k : n - 4 - k])
    return total / h


def smooth(drive, n):
    """Which inner samples have no border of two segments in their stencil."""
    h = drive.step_ns / NS
    t = h * np.arange(n)[4:-4]
    return np.all([np.abs(t - border) > 4.5 * h for border in borders(drive)], axis=0)


def assert_derivatives(motion, h, where):
    fastest = 2 * math.pi * 4.0
    for order in (0, 1):
        values = motion[:, 4 * order : 4 * order + 4]
        slopes = motion[4:-4, 4 * order + 4 : 4 * order + 8]
        error = np.abs(differentiate(values, h) - slopes)[where]
        # (omega h)^8 / 630 = 3e-16; rounding of the phase, 100 cycles, over omega h = 0.025
        assert error.max() < 2e-11 * fastest * np.abs(values).max()


@every_plan
def test_velocity_and_acceleration_are_the_derivatives(kind, quantity, direction, spacing):
    drive = drive_of(kind, quantity, direction, spacing)
    motion = drive.motion(0, drive.samples)
    assert_derivatives(motion, 1e-3, smooth(drive, len(motion)))


@every_plan
def test_degrees_of_freedom_move_in_phase_with_their_amplitudes(kind, quantity, direction, spacing):
    drive = drive_of(kind, quantity, direction, spacing)
    motion = drive.motion(0, drive.samples).reshape(-1, 3, 4)
    unit = motion[:, :, :1] / AMPLITUDE[0]
    # each column is one product with the amplitude
    assert np.allclose(motion, unit * np.array(AMPLITUDE), rtol=4 * EPS, atol=0)


@every_plan
@pytest.mark.parametrize('rate', [1000.0, 300.0])
def test_a_run_starts_and_ends_at_rest(kind, quantity, direction, spacing, rate):
    # 300 Hz rounds to a step that fits no whole number of times into the run
    drive = drive_of(kind, quantity, direction, spacing, ramp=1.2345, duration=5.4321)
    spec = spec_of(kind, quantity, direction, spacing, ramp=1.2345, duration=5.4321)
    drive = Drive.from_spec(spec, round(NS / rate))
    ends = drive.motion(0, drive.samples)[[0, -1]]
    # sin(pi) in floating point, eps, times pi / ramp
    assert np.abs(ends[:, :8]).max() < 1e-14
    assert drive.samples - 2 < drive.duration * NS / drive.step_ns <= drive.samples - 1 + 1e-6


@every_plan
def test_chunks_do_not_change_a_bit(kind, quantity, direction, spacing):
    drive = drive_of(kind, quantity, direction, spacing)
    whole = drive.motion(0, drive.samples)
    # small chunks: around the first border only
    for chunk, last in ((1, 1100), (7, 1500), (50, drive.samples), (1000, drive.samples)):
        pieces = [drive.motion(k, min(k + chunk, last)) for k in range(0, last, chunk)]
        assert np.array_equal(np.vstack(pieces), whole[:last])


def test_no_samples():
    assert drive_of().motion(5, 5).shape == (0, 12)


PI = Decimal('3.14159265358979323846264338327950288419716939937510')


def sweep_phase(drive, t):
    """Cycles at exact time t (Fraction) since the start of a one-way sweep, between its eases, and
    the frequency there, from the plan's own numbers in fifty digits."""
    ease, chirp = drive.segments[1:3]
    with localcontext(prec=50):
        e, rate = Decimal(ease.duration), Decimal(ease.end_rate)
        taken = Decimal(ease.start_hz) * e + rate * e * e * (Decimal('0.25') - 1 / PI**2)
        tau = Decimal(t.numerator) / Decimal(t.denominator) - e
        start, end = Decimal(chirp.start_hz), Decimal(chirp.end_hz)
        if isinstance(chirp, LinearChirp):
            slope = (end - start) / Decimal(chirp.duration)
            cycles, hz = start * tau + slope * tau * tau / 2, start + slope * tau
        else:
            growth = (end / start).ln() / Decimal(chirp.duration)
            gain = (growth * tau).exp()
            cycles, hz = start * (gain - 1) / growth, start * gain
        return Fraction(taken + cycles), Fraction(hz)


def exact_sine(cycles):
    """sin(2 pi cycles) of an exact phase."""
    return math.sin(2 * math.pi * float(cycles % 1))


@pytest.mark.parametrize('direction', ['forward', 'reverse'])
@pytest.mark.parametrize('spacing', ['linear', 'log'])
def test_a_sweep_has_no_phase_drift_after_a_day(direction, spacing):
    duration = 2e5
    drive = drive_of('sweep', 'displacement', direction, spacing, duration=duration)
    first = drive.frequency_hz(0.0)
    for sample in (50_000, 10_000_000, 100_000_000, 100_000_001, 180_000_003):
        t = Fraction(sample * drive.step_ns, NS) - 1  # ramp of 1 s
        cycles, _ = sweep_phase(drive, t)
        expected = exact_sine(cycles + Fraction(first))
        got = drive.motion(sample, sample + 1)[0, 0] / AMPLITUDE[0]
        # a few roundings of up to 6e5 cycles, which is all a double can carry
        assert got == pytest.approx(expected, abs=2 * math.pi * 4 * EPS * max(float(cycles), 1))


@pytest.mark.parametrize('quantity', QUANTITIES)
@pytest.mark.parametrize('direction', ['forward', 'reverse'])
@pytest.mark.parametrize('spacing', ['linear', 'log'])
def test_a_sweep_holds_the_amplitude_of_its_quantity(quantity, direction, spacing):
    drive = drive_of('sweep', quantity, direction, spacing)
    first = Fraction(1 if direction == 'forward' else 4)
    for sample in range(2010, 5990, 97):  # between the eases
        t = Fraction(sample, 1000) - 1
        cycles, hz = sweep_phase(drive, t)
        size = AMPLITUDE[0] / (2 * math.pi * float(hz)) ** QUANTITIES.index(quantity)
        expected = size * exact_sine(cycles + first)
        # some 20 cycles of phase, rounded a few times
        assert drive.motion(sample, sample + 1)[0, 0] == pytest.approx(expected, abs=1e-13 * size)


@pytest.mark.parametrize('quantity', QUANTITIES)
def test_a_dwell_holds_the_amplitude_of_its_quantity(quantity):
    drive = drive_of('sine', quantity, frequency=5.0)
    middle = drive.motion(1000, 7000).reshape(-1, 3, 4)[:, QUANTITIES.index(quantity)]
    # 5 Hz at 1 kHz samples each quarter of the cycle
    assert np.abs(middle).max(axis=0) == pytest.approx(AMPLITUDE, rel=1e-12)


@pytest.mark.parametrize('direction', DIRECTIONS)
@pytest.mark.parametrize(('spacing', 'space'), [('linear', np.linspace), ('log', np.geomspace)])
def test_a_stepped_sine_dwells_on_its_grid(direction, spacing, space):
    drive = drive_of('stepped_sine', 'velocity', direction, spacing, steps=4)
    up = space(1.0, 4.0, 4).tolist()
    steps = {'forward': up, 'reverse': up[::-1], 'there_and_back': up + up[-2::-1]}[direction]
    for number, hz in enumerate(steps):
        begin = 1.0 + number * 2.5
        # the dwell is 2 s of constant frequency
        assert {drive.frequency_hz(begin + s) for s in (0.0, 0.7, 1.99)} == {hz}
    assert drive.duration == pytest.approx(2 + 2.5 * len(steps) - 0.5)


@pytest.mark.parametrize(
    'segment',
    [
        Dwell(2.0, 3.0),
        LinearChirp(1.0, 4.0, 3.0),
        LogChirp(4.0, 1.0, 3.0),
        Glide(1.0, 3.0, 2.0),
        Ease(1.0, 0.5, -0.3, 3.0),
    ],
    ids=lambda segment: type(segment).__name__,
)
def test_segments_are_their_own_derivatives(segment):
    t = np.linspace(0, segment.duration, 2001)
    cycles = np.array(segment.cycles(t)).T
    assert cycles[0, 0] == 0.0
    slopes = differentiate(cycles[:, :3], t[1])
    # 12 cycles rounded, over a step of 1.5 ms
    assert np.allclose(slopes, cycles[4:-4, 1:], rtol=0, atol=12 * EPS / t[1] * 4)


def test_ramps_are_mirror_images():
    t = np.linspace(-0.5, 2.5, 301)
    rise, fall = fade_in(t, 2.0), fade_out(t, 2.0)
    assert np.allclose(rise[0] + fall[0], 1.0, atol=EPS)
    assert np.array_equal(rise[1], -fall[1])
    assert rise[0][t <= 0].max() == 0.0
    assert rise[0][t >= 2.0].min() == 1.0


@pytest.mark.parametrize('quantity', QUANTITIES)
@pytest.mark.parametrize('direction', DIRECTIONS)
@pytest.mark.parametrize('spacing', ['linear', 'log'])
def test_the_velocity_has_no_steps(quantity, direction, spacing):
    """A corner of the sweep rate would bend a held amplitude, and the velocity would step there:
    an impulse on the platform that the base sensor never shows."""
    drive = drive_of('sweep', quantity, direction, spacing, frequency_high=3.9)
    assert_no_velocity_steps(Drive(drive.segments, drive.amplitude, drive.order, 1.0, 10_000))


@pytest.mark.parametrize('name', scenario.names())
def test_no_scenario_steps_its_velocity(name):
    assert_no_velocity_steps(Drive.from_spec(scenario.load(name), 10_000))


def assert_no_velocity_steps(drive):
    for border in borders(drive):
        k = round(border * 1e5)
        before, after = drive.motion(k - 2, k - 1)[0], drive.motion(k + 1, k + 2)[0]
        velocity, acceleration = slice(4, 8), slice(8, 12)
        # carried from either side to the corner by its own acceleration
        left = before[velocity] + 2e-5 * before[acceleration]
        right = after[velocity] - 1e-5 * after[acceleration]
        size = np.abs(drive.motion(k - 50_000, k + 50_000)[:, velocity]).max()
        # third derivatives times (20 us)²: (2 pi 20 Hz 20 us)² = 6e-6 of the amplitude
        assert np.abs(left - right).max() < 1e-5 * size


@pytest.mark.parametrize('direction', ['forward', 'reverse'])
@pytest.mark.parametrize('spacing', ['linear', 'log'])
@pytest.mark.parametrize('duration', [0.5, 6.0, 600.0])
def test_a_sweep_runs_from_end_to_end_of_its_band(direction, spacing, duration):
    drive = drive_of('sweep', 'displacement', direction, spacing, duration=duration)
    hz = np.array([drive.frequency_hz(1.0 + x * duration) for x in np.linspace(0.0, 1.0, 200)])
    ends = (1.0, 4.0) if direction == 'forward' else (4.0, 1.0)
    # rounding of times and of the growth that the eases leave to a logarithmic sweep
    assert (hz[0], hz[-1]) == (pytest.approx(ends[0], rel=1e-12), pytest.approx(ends[1], rel=1e-9))
    assert (np.diff(hz) * (ends[1] - ends[0]) > 0.0).all()


def stopped(after, ramp=1.0, **more):
    spec = spec_of('sine', 'acceleration', frequency=2.0, **{'ramp': ramp, **more})
    stage = ExciterStage(spec, scenario.step_ns_of(spec))
    pieces = [stage.take(after)]
    stage.stop()
    samples = stage.samples
    stage.stop()  # once is enough
    assert stage.samples == samples
    while stage.given < stage.samples:
        pieces.append(stage.take(333))
    assert len(stage.take(10)) == 0
    return stage, np.vstack([piece.data for piece in pieces])


@pytest.mark.parametrize('after', [500, 3021, 7600])
def test_a_stopped_exciter_ramps_down_to_rest(after):
    """In the first ramp, in the middle of the run, in the last ramp."""
    stage, motion = stopped(after)
    assert len(motion) == stage.samples == min(after + 1001, 8001)
    t = 1e-3 * np.arange(len(motion))[4:-4]
    corners = [*borders(stage.drive), after * 1e-3]
    where = np.all([np.abs(t - corner) > 4.5e-3 for corner in corners], axis=0)
    assert_derivatives(motion, 1e-3, where)
    assert np.abs(motion[-1, :8]).max() < 1e-14  # sin(pi) in floating point
    untouched = stage.drive.motion(0, after + 1)
    assert np.array_equal(motion[: after + 1, :8], untouched[:, :8])


def test_a_stop_reaches_rest_though_the_ramp_is_no_whole_number_of_steps():
    _, motion = stopped(3000, ramp=1.00043)
    assert np.abs(motion[-1, :8]).max() < 1e-14


def test_an_exciter_stopped_before_its_first_sample_stays_at_rest_in_position():
    stage, motion = stopped(0)
    assert stage.samples == 1001
    assert not motion[0].any()


def test_stage_stamps_follow_the_grid():
    spec = spec_of()
    stage = ExciterStage(spec, 1_000_000)
    stage.start(123)
    first, second = stage.take(10), stage.take(5)
    assert first.stamps_ns.tolist() == list(range(123, 10_000_123, 1_000_000))
    assert second.stamps_ns.tolist() == list(range(10_000_123, 15_000_123, 1_000_000))
    assert first.channels[0].name == 'vertical.position'
    assert [c.unit for c in first.channels[::4]] == ['m', 'm/s', 'm/s²']
    assert [c.unit for c in first.channels[2::4]] == ['rad', 'rad/s', 'rad/s²']


def test_a_drive_of_nothing_is_refused():
    still = {f'amplitude.{dof}': 0.0 for dof in DOFS}
    with pytest.raises(InputError, match=r'every excitation\.amplitude is 0.*set excitation'):
        drive_of(**still)


@pytest.mark.parametrize('kind', EXCITATIONS)
def test_a_drive_that_would_alias_is_refused(kind):
    with pytest.raises(InputError, match=r'101 Hz needs a sample rate .* raise run\.rate above 1'):
        drive_of(kind, frequency=101.0, frequency_high=101.0)
    drive_of(kind, frequency=100.0, frequency_high=100.0)


@pytest.mark.parametrize('kind', ['sweep', 'stepped_sine'])
@pytest.mark.parametrize('low', [4.0, 5.0])
def test_an_empty_band_is_refused(kind, low):
    with pytest.raises(InputError, match=r'frequency_low = . Hz is not below .* set .* to reverse'):
        drive_of(kind, frequency_low=low, frequency_high=4.0)
