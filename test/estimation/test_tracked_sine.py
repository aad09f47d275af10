"""Laws of the tracked sine: exact on steady and swept sines, blind to offset and chunks."""

import numpy as np
import pytest
from estimation_signals import (
    STEP_NS,
    STEP_S,
    closed_form,
    columns,
    complex_t,
    linear_top,
    pushed,
    sine,
    there_and_back,
    times,
)

from qzs_rig.estimation import ESTIMATORS, TrackedSine, TrackedSineSettings

SETTINGS = TrackedSineSettings()
DC = 9.81


def tracked(base, top, settings=SETTINGS, **options):
    return pushed(TrackedSine(settings, STEP_NS), base, top, **options)


@pytest.mark.parametrize('frequency', [0.5, 1.0, 3.3, 7.77, 20.0])
@pytest.mark.parametrize('dof', range(4))
def test_a_steady_sine_gives_the_closed_form(frequency, dof):
    t = times(30.0 / frequency)
    exact = closed_form(frequency, 0.05)
    base, top = np.zeros((2, len(t), 4))
    base[:, dof] = DC + sine(t, frequency, 0.5)
    top[:, dof] = DC + sine(t, frequency, 0.5 * abs(exact), np.angle(exact))
    (curve,) = tracked(base, top).result().curves
    assert curve.direction == 'none'
    assert len(curve.frequency_hz) == 1
    # Linear least squares is exact here; what is left is rounding and the residual phase.
    assert curve.frequency_hz[0] == pytest.approx(frequency, rel=1e-7)
    assert complex_t(curve)[0] == pytest.approx(exact, rel=1e-7)


@pytest.mark.parametrize('zeta', [0.1, 0.2])
def test_a_slow_sweep_over_a_linear_platform_gives_the_closed_form_both_ways(zeta):
    # The steady answer lags by (dω/dt)/2 T'' ~ 2π r Q²/ω0² T: 0.5 % here, whatever the estimator.
    leg, oversampling = 600.0, 4
    fine = np.arange(round(2 * leg / STEP_S) * oversampling) * STEP_S / oversampling
    frequency, phase = there_and_back(fine, 2.0, 5.0, leg)
    base = 0.01 * (2 * np.pi * frequency) ** 2 * np.sin(phase)
    top = linear_top(base, STEP_S / oversampling, zeta)
    estimate = tracked(
        columns(DC + base[::oversampling]), columns(DC + top[::oversampling])
    ).result()
    assert [curve.direction for curve in estimate.curves] == ['forward', 'reverse']
    for curve in estimate.curves:
        settled = np.abs(curve.frequency_hz - 2.0) > 0.05
        ratio = complex_t(curve)[settled] / closed_form(curve.frequency_hz[settled], zeta)
        assert np.abs(np.abs(ratio) - 1.0).max() < 0.01
        assert np.degrees(np.abs(np.angle(ratio))).max() < 1.0


def test_the_lag_of_a_faster_sweep_is_the_platforms_own():
    # First order of the swept response: T - i (dω/dt)/2 T'' (Cramer & Crandall, passage through
    # resonance); the estimator must show it, not smear it.
    leg, zeta = 120.0, 0.1
    fine = np.arange(round(2 * leg / STEP_S) * 4) * STEP_S / 4
    _, phase = there_and_back(fine, 2.0, 5.0, leg)
    base = np.sin(phase)
    top = linear_top(base, STEP_S / 4, zeta)
    curve = tracked(columns(base[::4]), columns(top[::4])).result().curves[0]
    rate, h = 2 * np.pi * 3.0 / leg, 1e-3
    inside = slice(20, -5)
    f = curve.frequency_hz[inside]
    bend = sum(k * closed_form(f + s * h, zeta) for k, s in ((1, -1), (-2, 0), (1, 1)))
    lagging = closed_form(f, zeta) - 0.5j * rate * bend / (2 * np.pi * h) ** 2
    steady_error = np.abs(complex_t(curve)[inside] / closed_form(f, zeta) - 1).max()
    assert np.abs(complex_t(curve)[inside] / lagging - 1).max() < 0.15 * steady_error


@pytest.mark.parametrize(('low', 'high', 'leg'), [(0.5, 20.0, 60.0), (1.0, 4.0, 60.0)])
def test_a_constant_ratio_is_kept_all_along_a_there_and_back_sweep(low, high, leg):
    t = times(2 * leg)
    frequency, phase = there_and_back(t, low, high, leg)
    amplitude = 0.002 * (2 * np.pi * frequency) ** 2
    base, top = DC + amplitude * np.sin(phase), DC + 0.7 * amplitude * np.sin(phase - 0.3)
    estimate = tracked(columns(base), columns(top)).result()
    assert [curve.direction for curve in estimate.curves] == ['forward', 'reverse']
    for curve in estimate.curves:
        # At 0.5 Hz a window spans a factor three in frequency; there the envelope's cubic shows.
        well = curve.frequency_hz > 2 * low
        error = np.abs(complex_t(curve) / (0.7 * np.exp(-0.3j)) - 1)
        assert error[well].max() < 1e-3
        assert error.max() < 1e-2
        span = curve.frequency_hz.max() - curve.frequency_hz.min()
        assert span > 0.9 * (high - low)


def test_frequency_comes_from_the_base_alone():
    t = times(20.0)
    base = columns(sine(t, 2.0))
    quiet = tracked(base, columns(0.1 * sine(t, 2.0)))
    busy = tracked(base, columns(0.1 * sine(t, 2.0) + sine(t, 2.9, 3.0)))
    assert [p.frequency_hz for p in quiet.points] == [p.frequency_hz for p in busy.points]
    assert busy.points[5].top_residual > 100 * quiet.points[5].top_residual


def test_distortion_is_the_root_sum_square_of_the_known_harmonics():
    t = times(20.0)
    fundamental, second, fifth = sine(t, 3.0, 2.0), sine(t, 6.0, 0.3, 1.0), sine(t, 15.0, 0.4, 2.0)
    (curve,) = tracked(columns(sine(t, 3.0)), columns(fundamental + second + fifth)).result().curves
    assert curve.thd[0] == pytest.approx(np.hypot(0.3, 0.4) / 2.0, rel=1e-6)
    assert curve.magnitude[0] == pytest.approx(2.0, rel=1e-6)


def test_without_a_harmonic_below_nyquist_distortion_is_unknown():
    t = times(4.0)
    settings = TrackedSineSettings(frequency_max=200.0)
    base = columns(sine(t, 150.0))
    (curve,) = tracked(base, 2 * base, settings).result().curves
    assert np.isnan(curve.thd[0])
    assert curve.magnitude[0] == pytest.approx(2.0, rel=1e-9)


@pytest.mark.parametrize('noise', [0.01, 0.05])
def test_noise_scatters_the_answer_no_more_than_its_share_of_the_window(noise):
    t = times(120.0)
    rng = np.random.default_rng(7)
    base, top = (
        columns(DC + sine(t, 2.0, 0.5 * gain, -0.5 * (gain - 1)))
        + noise * rng.standard_normal((len(t), 4))
        for gain in (1.0, 3.0)
    )
    points = tracked(base, top).points
    vertical = [p for p in points if p.dof == 'vertical']
    assert len(vertical) > 230
    assert len(points) == len(vertical)
    error = np.array([p.transmissibility for p in vertical]) / (3 * np.exp(-1j)) - 1
    # White noise through a window of N samples: sigma/A sqrt(2/N), times 1.9 for the taper and
    # the free envelope, for base and top; five standard deviations for the largest of 236.
    expected = noise / 0.5 * np.sqrt(2 * 1.9**2 / 1000)
    assert np.abs(error).max() < 5 * expected
    assert abs(error.mean()) < expected


@pytest.mark.parametrize('name', sorted(ESTIMATORS))
@pytest.mark.parametrize('chunk', [1, 7, 50, 1000])
def test_the_bits_do_not_depend_on_the_chunks(name, chunk):
    rng = np.random.default_rng(3)
    t = times(24.0)
    _, phase = there_and_back(t, 2.0, 6.0, 10.0)
    frequency = np.where(t > 16.0, 0.0, 1.0)
    base = columns(frequency * np.sin(phase), sine(t, 3.0)) + 0.01 * rng.standard_normal(
        (len(t), 4)
    )
    top = base[:, ::-1] + 0.5 * base
    whole = pushed(ESTIMATORS[name](SETTINGS, STEP_NS), base, top)
    cut = pushed(ESTIMATORS[name](SETTINGS, STEP_NS), base, top, chunk)
    assert cut.points == whole.points
    assert len(whole.points) > 40
    assert cut.result().to_json() == whole.result().to_json()


def test_pauses_steps_and_missing_samples_are_survived_and_counted():
    t = times(40.0)
    base = np.select(
        [t < 10, t < 14, t < 25], [sine(t, 2.0), 0.0 * t, sine(t, 5.0)], sine(t, 5.5, 1.0, 1.0)
    )
    base[16_000:16_010] = np.nan
    estimator = tracked(columns(base), columns(2.0 * base))
    quality = estimator.result().quality['dofs']['vertical']
    assert quality['locks'] >= 3
    assert quality['not_finite'] > 0
    assert quality['idle_s'] > 2.0
    # The ratio holds wherever the base is accepted, across the step included.
    assert all(abs(p.transmissibility - 2.0) < 1e-6 for p in estimator.points)
    seen = np.array([p.time_s for p in estimator.points])
    for first, last in ((1.1, 8.9), (15.0, 24.4), (26.0, 31.5), (33.0, 39.4)):
        assert np.diff(seen[(seen > first) & (seen < last)]).max() < 0.6
    assert not ((seen > 10.5) & (seen < 13.5)).any()
    assert (np.diff(seen) > 0).all()


def test_a_base_below_the_floor_gives_nothing():
    t = times(10.0)
    base = columns(sine(t, 2.0, 0.9 * SETTINGS.floor_acceleration))
    base[:, 2] = sine(t, 2.0, 0.9 * SETTINGS.floor_rate)
    estimator = tracked(base, base)
    assert estimator.points == []
    assert estimator.result().curves == ()
    assert estimator.latest('vertical') is None


def test_random_motion_gives_no_points():
    rng = np.random.default_rng(5)
    base = rng.standard_normal((20_000, 4))
    assert len(tracked(base, base).points) == 0


def test_memory_is_bounded_and_progress_told():
    estimator = TrackedSine(SETTINGS, STEP_NS)
    before = estimator._buffer._data.nbytes
    t = times(300.0)
    pushed(estimator, columns(sine(t, 2.0)), columns(sine(t, 2.0)), 100)
    assert estimator._buffer._data.nbytes == before
    assert estimator.progress == (150_000, len(estimator.points))
    frequency, value = estimator.latest('vertical')
    assert frequency == pytest.approx(2.0)
    assert value == pytest.approx(1.0)


def test_a_base_of_another_shape_is_refused():
    with pytest.raises(ValueError, match=r'base \(5, 3\) and top \(5, 4\) must both be \(n, 4\)'):
        TrackedSine(SETTINGS, STEP_NS).push(np.zeros((5, 3)), np.zeros((5, 4)))


def test_unknown_degrees_of_freedom_and_steps_are_refused():
    with pytest.raises(ValueError, match='unknown degrees of freedom'):
        TrackedSine(SETTINGS, STEP_NS, ['heave'])
    with pytest.raises(ValueError, match='step_ns = 0 is not positive'):
        TrackedSine(SETTINGS, 0)
