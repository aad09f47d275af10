"""The stated uncertainty against what repeated measurements show."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from qzs_rig.estimation import ESTIMATORS, TrackedSineSettings
from qzs_rig.estimation.estimate import Curve, Estimate, from_document
from qzs_rig.estimation.track import noise, unrest

STEP_NS = 5_000_000
T = 0.4 * np.exp(-0.7j)


def measured(seed, estimator='tracked_sine', sigma=0.05, seconds=40.0):
    """Curve of a sine dwell at 2 Hz, both sensors with white noise, T known."""
    t = np.arange(0.0, seconds, STEP_NS / 1e9)
    turning = np.exp(2j * np.pi * 2.0 * t)
    rng = np.random.default_rng(seed)
    base = turning.imag + sigma * rng.standard_normal(len(t))
    top = (T * turning).imag + sigma * rng.standard_normal(len(t))
    stage = ESTIMATORS[estimator](TrackedSineSettings(), STEP_NS, ('vertical',))
    stage.push(base[:, None], top[:, None])
    return stage


def test_noise_is_stated_as_large_as_it_scatters():
    points = [point for seed in range(4) for point in measured(seed).points]
    scatter = np.std([abs(point.transmissibility) for point in points]) / abs(T)
    stated = np.sqrt(np.mean([noise(point) ** 2 for point in points]))
    # 300 overlapping windows: the scatter is known to about 10 %; the weight's factor is rounded
    assert stated == pytest.approx(scatter, rel=0.25)


@pytest.mark.parametrize('estimator', ['tracked_sine', 'stepped_sine'])
def test_a_dwell_is_known_within_its_uncertainty(estimator):
    (curve,) = measured(1, estimator, sigma=0.001).result().curves
    (off,) = np.abs(curve.magnitude - abs(T)) / curve.uncertainty
    assert off < 3.0
    assert curve.uncertainty[0] < 0.01 * abs(T)


def test_a_clean_signal_is_known_to_rounding():
    (curve,) = measured(1, sigma=0.0).result().curves
    assert curve.uncertainty[0] < 1e-9


def test_a_sweep_is_unsure_by_what_changes_within_its_window():
    """T = f at 1 Hz/s: half a window of 4 periods moves ln T by 2/f², uniformly distributed."""
    time_s = np.linspace(0.0, 3.0, 61)
    f = 1.0 + time_s
    expected = 0.5 * 4.0 / f**2 / math.sqrt(3.0)
    # central differences of a logarithm, 0.05 s apart; the ends are one-sided
    np.testing.assert_allclose(unrest(time_s, f, f, 4.0)[1:-1], expected[1:-1], rtol=1e-3)
    assert unrest(time_s[:1], f[:1], f[:1], 4.0).tolist() == [0.0]


def test_uncertainty_survives_the_file_and_may_be_missing():
    f = np.array([1.0, 2.0])
    curve = Curve('vertical', 'none', 'sine', 'fundamental', f, f, f, f, 0.1 * f)
    document = json.loads(Estimate((curve,)).to_json())
    assert np.array_equal(from_document(document).curves[0].uncertainty, 0.1 * f)
    del document['curves'][0]['uncertainty']
    assert np.isnan(from_document(document).curves[0].uncertainty).tolist() == [True, True]
