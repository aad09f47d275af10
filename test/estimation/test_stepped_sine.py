"""Laws of the stepped sine: one settled point a step, in the order the steps came."""

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
    times,
)

from qzs_rig.estimation import SteppedSine, TrackedSine, TrackedSineSettings

ZETA = 0.1


def staircase(frequencies, hold_s, oversampling=4):
    """Base and exact linear top for steps of `frequencies`, phase continuous."""
    t = np.arange(round(hold_s * len(frequencies) / STEP_S) * oversampling) * STEP_S / oversampling
    frequency = np.asarray(frequencies)[np.minimum((t / hold_s).astype(int), len(frequencies) - 1)]
    base = np.sin(2 * np.pi * np.cumsum(frequency) * STEP_S / oversampling)
    top = linear_top(base, STEP_S / oversampling, ZETA)
    return columns(9.81 + base[::oversampling]), columns(9.81 + top[::oversampling])


def test_each_step_gives_its_settled_closed_form_up_and_down():
    up = [2.0, 2.5, 3.0, 3.5, 4.0]
    steps = up + up[-2::-1]
    estimate = pushed(SteppedSine(TrackedSineSettings(), STEP_NS), *staircase(steps, 14.0)).result()
    assert [curve.direction for curve in estimate.curves] == ['forward', 'reverse']
    found = np.concatenate([curve.frequency_hz for curve in estimate.curves])
    # A window that still sees the step before may be averaged in.
    np.testing.assert_allclose(found, steps, rtol=5e-5)
    assert estimate.quality['unsettled'] == []
    for curve in estimate.curves:
        # The settle tolerance is 0.2 %; the decay left at that point is a few times it.
        np.testing.assert_allclose(
            complex_t(curve), closed_form(curve.frequency_hz, ZETA), rtol=4e-3
        )


def test_a_step_that_never_settles_is_left_out_and_reported():
    t = times(40.0)
    base = np.where(t < 20, sine(t, 2.0), sine(t, 3.0))
    top = np.where(t < 20, 2 * base, base * (1 + 0.5 * sine(t, 0.2)))
    estimate = pushed(
        SteppedSine(TrackedSineSettings(), STEP_NS), columns(base), columns(top)
    ).result()
    (curve,) = estimate.curves
    assert curve.direction == 'none'
    np.testing.assert_allclose(curve.frequency_hz, [2.0], rtol=1e-6)
    (report,) = estimate.quality['unsettled']
    assert report['dof'] == 'vertical'
    assert report['frequency_hz'] == pytest.approx(3.0, rel=1e-4)
    assert report['scatter'] > 0.002


@pytest.mark.parametrize('estimator', [SteppedSine, TrackedSine])
def test_a_dwell_with_ramps_gives_one_steady_point(estimator):
    oversampling = 4
    t = np.arange(round(40.0 / STEP_S) * oversampling) * STEP_S / oversampling
    ramp = 0.5 - 0.5 * np.cos(np.pi * np.clip(np.minimum(t, 40.0 - t) / 3.0, 0.0, 1.0))
    base = ramp * sine(t, 3.0)
    top = linear_top(base, STEP_S / oversampling, ZETA)
    estimate = pushed(
        estimator(TrackedSineSettings(), STEP_NS),
        columns(base[::oversampling]),
        columns(top[::oversampling]),
    ).result()
    (curve,) = estimate.curves
    assert curve.direction == 'none'
    assert len(curve.frequency_hz) == 1
    assert estimate.quality['unsettled'] == []
    assert complex_t(curve)[0] == pytest.approx(closed_form(3.0, ZETA), rel=1e-4)


def test_a_dwell_that_never_settles_is_averaged_and_reported_by_the_tracked_sine():
    t = times(40.0)
    base = sine(t, 3.0)
    top = base * (1 + 0.5 * sine(t, 0.2))
    estimate = pushed(
        TrackedSine(TrackedSineSettings(), STEP_NS), columns(base), columns(top)
    ).result()
    assert len(estimate.curves) == 1
    assert estimate.curves[0].magnitude[0] == pytest.approx(1.0, abs=0.2)
    assert len(estimate.quality['unsettled']) == 1
