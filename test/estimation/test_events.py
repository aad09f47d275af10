"""Laws of the events: onset and peak of linear platforms in closed form, jumps only at folds."""

import numpy as np
import pytest
from estimation_signals import (
    NATURAL,
    STEP_NS,
    STEP_S,
    closed_form,
    columns,
    linear_top,
    pushed,
    there_and_back,
    times,
)
from scipy.integrate import solve_ivp

from qzs_rig.estimation import TrackedSine, TrackedSineSettings
from qzs_rig.estimation.estimate import Curve
from qzs_rig.estimation.events import find_events

FN = NATURAL / (2 * np.pi)


def curve_of(frequency, magnitude, direction='forward'):
    if direction == 'reverse':
        frequency, magnitude = frequency[::-1], magnitude[::-1]
    return Curve(
        'vertical',
        direction,
        'tracked_sine',
        'fundamental',
        frequency,
        magnitude,
        *np.zeros((2, len(frequency))),
    )


def by_kind(events):
    return {event.kind: event for event in events}


@pytest.mark.parametrize('direction', ['forward', 'reverse'])
@pytest.mark.parametrize('settled', [False, True])
@pytest.mark.parametrize('zeta', [0.01, 0.02, 0.05, 0.1, 0.2, 0.3])
@pytest.mark.parametrize('points', [40, 400, 4000])
def test_a_linear_curve_has_its_onset_and_peak_but_no_jump(direction, settled, zeta, points):
    frequency = np.linspace(0.5 * FN, 3.0 * FN, points)
    curve = curve_of(frequency, np.abs(closed_form(frequency, zeta)), direction)
    found = by_kind(find_events(curve, settled))
    assert set(found) <= {'onset', 'peak'}
    # T = 1 at sqrt(2) f_n whatever the damping; a point's spacing is what a curve can tell.
    onset = found['onset']
    assert abs(onset.frequency_hz - np.sqrt(2) * FN) < onset.resolution_hz
    # Rao, Mechanical Vibrations, 9.100: x = sqrt(sqrt(1 + 8 ζ²) - 1) / (2 ζ).
    peak = np.sqrt(np.sqrt(1 + 8 * zeta**2) - 1) / (2 * zeta) * FN
    assert abs(found['peak'].frequency_hz - peak) < found['peak'].resolution_hz


def test_the_bound_that_tells_jumps_holds_for_every_linear_platform():
    frequency = np.geomspace(0.01, 100.0, 20_001) * FN
    for zeta in (0.0005, 0.01, 0.1, 0.3, 1.0):
        gain = np.log1p(1 / np.abs(closed_form(frequency, zeta)))
        slope = np.abs(np.diff(gain) / np.diff(np.log(frequency)))
        assert slope.max() <= 2.0 + 1e-6


@pytest.mark.parametrize(('direction', 'kind'), [('forward', 'jump_down'), ('reverse', 'jump_up')])
def test_a_drawn_jump_is_found_where_it_was_drawn_and_takes_the_onset(direction, kind):
    frequency = np.linspace(1.0, 5.0, 401)
    magnitude = np.where(frequency < 2.995, 1.0 + frequency, 0.4)
    found = by_kind(find_events(curve_of(frequency, magnitude, direction)))
    assert set(found) == {'onset', 'peak', kind}
    for event in (found[kind], found['onset']):
        assert event.frequency_hz == pytest.approx(2.995, abs=0.01)
        assert event.resolution_hz == pytest.approx(0.01)
    before = 4.0 if direction == 'forward' else 0.4
    assert found[kind].magnitude == pytest.approx(before, rel=0.02)


def test_a_curve_that_ends_at_its_largest_value_has_no_peak():
    frequency = np.linspace(1.0, 5.0, 50)
    assert find_events(curve_of(frequency, frequency)) == ()
    assert find_events(curve_of(frequency, 0.5 / frequency)) == ()


def test_a_dwell_has_no_events():
    assert find_events(curve_of(np.array([2.0]), np.array([3.0]), 'none')) == ()


@pytest.mark.parametrize('zeta', [0.0125, 0.02215, 0.05, 0.1, 0.3])
@pytest.mark.parametrize('noise', [0.0, 0.01])
def test_a_linear_platform_swept_at_the_iso_limit_shows_no_jump(zeta, noise):
    # ISO 7626-2: at most 54 (f_n/Q)² Hz/min, 0.9 (2 ζ f_n)² Hz/s.
    rate = min(0.9 * (2 * zeta * FN) ** 2, 0.33)
    leg = min(3.0 / rate, 250.0)
    t = np.arange(round(2 * leg / STEP_S) * 2) * STEP_S / 2
    frequency, phase = there_and_back(t, FN - rate * leg / 3, FN + rate * leg * 2 / 3, leg)
    base = 0.01 * (2 * np.pi * frequency) ** 2 * np.sin(phase)
    top = linear_top(base, STEP_S / 2, zeta)
    rng = np.random.default_rng(1)
    scatter = noise * rng.standard_normal((2, len(base[::2])))
    estimator = TrackedSine(TrackedSineSettings(), STEP_NS)
    pushed(estimator, columns(base[::2] + scatter[0]), columns(top[::2] + scatter[1]))
    estimate = estimator.result()
    assert [curve.direction for curve in estimate.curves] == ['forward', 'reverse']
    assert {event.kind for event in estimate.events} <= {'onset', 'peak'}
    assert {event.direction for event in estimate.events if event.kind == 'peak'} == {
        'forward',
        'reverse',
    }


ZETA, CUBIC, HEIGHT = 0.1, 100.0, 0.02


def duffing(leg, low, high):
    """Base and top acceleration of a hardening platform w'' + 2ζω w' + ω²(w + CUBIC w³) = -v''
    on a sweep there and back, by DOP853."""

    def base_acceleration(t):
        frequency, phase = there_and_back(t, low, high, leg)
        return HEIGHT * (2 * np.pi * frequency) ** 2 * np.sin(phase)

    def restoring(w, rate):
        return 2 * ZETA * NATURAL * rate + NATURAL**2 * (w + CUBIC * w**3)

    def motion(t, y):
        back = t - leg if t > leg else 0.0
        slope = (high - low) / leg
        f = low + slope * t - 2 * slope * back
        phase = 2 * np.pi * (low * t + slope * t * t / 2 - slope * back * back)
        a = HEIGHT * (2 * np.pi * f) ** 2 * np.sin(phase)
        return y[1], -restoring(y[0], y[1]) - a

    t = times(2 * leg)
    y = solve_ivp(motion, (0.0, t[-1]), [0.0, 0.0], 'DOP853', t, rtol=1e-6, atol=1e-9).y
    return base_acceleration(t), -restoring(y[0], y[1])


def folds():
    """Lowest and highest frequency with three balances of one harmonic: real roots of
    (9/16) c² X³ + (3/2) c (1 - Ω²) X² + ((1 - Ω²)² + (2ζΩ)²) X - (HΩ²)², X = W² (MODEL.md, 5)."""
    ratio = np.linspace(1.0, 3.0, 4001)
    stiff = 1 - ratio**2
    count = [
        np.sum(np.abs(np.roots(coefficients).imag) < 1e-12)
        for coefficients in np.stack(
            [
                9 / 16 * CUBIC**2 * np.ones_like(ratio),
                1.5 * CUBIC * stiff,
                stiff**2 + (2 * ZETA * ratio) ** 2,
                -((HEIGHT * ratio**2) ** 2),
            ],
            axis=1,
        )
    ]
    three = ratio[np.array(count) == 3] * FN
    return three.min(), three.max()


def test_a_hardening_platform_jumps_down_forward_and_up_in_reverse_at_its_folds():
    base, top = duffing(120.0, 3.0, 8.0)
    estimator = pushed(TrackedSine(TrackedSineSettings(), STEP_NS), columns(base), columns(top))
    jumps = [event for event in estimator.result().events if 'jump' in event.kind]
    assert [(jump.direction, jump.kind) for jump in jumps] == [
        ('forward', 'jump_down'),
        ('reverse', 'jump_up'),
    ]
    low, high = folds()
    # One harmonic is good to about 1 %; the sweep (0.042 Hz/s) overruns each fold by about a
    # second of slow passage.
    assert -0.01 < jumps[0].frequency_hz / high - 1 < 0.04
    assert -0.04 < jumps[1].frequency_hz / low - 1 < 0.01
