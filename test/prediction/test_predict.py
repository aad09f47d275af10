"""The prediction by harmonic balance against its source, against one term, and against time."""

from __future__ import annotations

import numpy as np
import pytest

from qzs_rig import scenario
from qzs_rig.mechanics.platform import Platform
from qzs_rig.prediction.labels import label_all
from qzs_rig.prediction.predict import by_harmonic_balance, by_single_term, predict, range_hz
from qzs_rig.run import in_process
from qzs_rig.theory.balance.frequency_response import FrequencyResponse, frequency_response
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import DOFS

LOUD = {'excitation.amplitude.vertical': 4.0}


@pytest.fixture(scope='module')
def loud():
    (prediction,) = predict(scenario.of(LOUD))
    return prediction


def test_the_folds_are_those_that_were_located(loud):
    own = Oscillator.driven(scenario.of(LOUD), 'vertical')
    source = frequency_response(own, *map(own.omega, range_hz(scenario.of(LOUD))), isolas=False)
    hz = [fold.frequency_hz for fold in loud.folds]
    assert hz == pytest.approx(sorted(e.omega * own.hertz for e in source.folds), rel=1e-12)
    up, down = loud.folds
    assert (up.kind, up.leaves, up.lands) == ('jump_up', 'lower', 'upper')
    assert (down.kind, down.leaves, down.lands) == ('jump_down', 'upper', 'lower')
    assert loud.method == 'harmonic_balance' and loud.label == 'theory, harmonic balance'


def test_branches_rise_in_frequency_and_only_the_middle_is_unstable(loud):
    assert {branch.name for branch in loud.branches} == {'lower', 'middle', 'upper'}
    for branch in loud.branches:
        assert (np.diff(branch.frequency_hz) >= 0).all()
        steady = branch.name != 'middle'
        assert (branch.stable.all(), branch.stable.any()) == (steady, steady)
        assert ((branch.phase_deg > -180) & (branch.phase_deg <= 180)).all()


def test_between_the_computed_points_it_is_the_same_curve(loud):
    """Continued over a part of the range, it has its points elsewhere."""
    own = Oscillator.driven(scenario.of(LOUD), 'vertical')
    hertz = own.hertz
    again = frequency_response(own, 1.9 / hertz, 2.2 / hertz)
    assert len(again.branches) == 3
    branches = {branch.name: branch for branch in loud.branches}
    ranked = sorted(again.branches, key=lambda path: path.amplitude.mean())
    for name, path in zip(('lower', 'middle', 'upper'), ranked, strict=True):
        mine, f = branches[name], path.omega * hertz
        # cubic between points 3 % apart, then linear between twelve times as many
        np.testing.assert_allclose(
            np.interp(f, mine.frequency_hz, mine.transmissibility), path.T, rtol=5e-5
        )


def test_a_small_motion_of_an_odd_law_is_one_term():
    """What the third harmonic adds falls with the square of the amplitude."""
    gaps = []
    for amplitude in (0.4, 0.04):
        given = {'platform.law': 'symmetric', 'platform.zeta': 0.1, 'platform.k3_hat': 0.5}
        given |= {'excitation.amplitude.vertical': amplitude}
        spec = scenario.of(given)
        own = Oscillator.driven(spec, 'vertical'), *range_hz(spec)
        (exact,) = by_harmonic_balance(*own).branches
        (rough,) = by_single_term(*own).branches
        f = np.geomspace(1.0, 4.0, 50)
        T = [np.interp(f, b.frequency_hz, b.transmissibility) for b in (exact, rough)]
        gaps.append(np.abs(T[0] / T[1] - 1).max())
    assert gaps[0] < 2e-2 and gaps[1] < 5e-4  # 5e-4: linear interpolation in the one-term grid


@pytest.mark.parametrize('dof', DOFS)
def test_a_dwell_is_where_the_branch_says(dof):
    given = {
        'run.rate': 500.0,
        'platform.zeta': 0.1,
        'platform.L0_hat': 0.08,
        'excitation.kind': 'sine',
        'excitation.frequency': 2.2,
        'analyzer.estimator': 'stepped_sine',
        'excitation.duration': 30.0,
        f'excitation.amplitude.{dof}': 2.0,
    }
    spec = scenario.of(given)
    strokes, number = [], DOFS.index(dof)

    def tap(base, out):
        strokes.append(out.top.data[:, number] - base.data[:, number])

    estimate = in_process.run(spec, tap=tap).estimate
    (prediction,) = predict(spec)
    assert prediction.method == 'harmonic_balance'
    (curve,) = (curve for curve in estimate.curves if curve.dof == dof)
    (found,) = (found for found in label_all(estimate, [prediction]) if found.dof == dof)
    # sampled 227 times a period, integrated by RK4: 1e-4
    np.testing.assert_allclose(curve.magnitude, found.transmissibility, rtol=1e-3)
    np.testing.assert_allclose(curve.phase_deg, found.phase_deg, atol=0.1)
    (branch,) = (b for b in prediction.branches if b.name == found.branch[0])
    stroke = np.interp(2.2, branch.frequency_hz, branch.stroke)
    late = np.concatenate(strokes)[20 * 500 : 30 * 500]
    assert np.abs(late).max() == pytest.approx(stroke, rel=2e-3)


def test_the_stroke_of_a_trimmed_payload_is_measured_from_where_it_rests():
    given = {'platform.payload_trim': 0.5, 'excitation.amplitude.vertical': 0.01}
    (prediction,) = predict(scenario.of(given))
    platform = Platform.from_spec(scenario.of(given))
    sag = abs(platform.rest[0] * platform.length[0])
    assert max(branch.stroke.max() for branch in prediction.branches) < 0.5 * sag


def test_a_coupled_platform_is_predicted_by_its_projection_and_says_so():
    (prediction,) = predict(scenario.of({'platform.law': 'geometric'} | LOUD))
    assert prediction.label == 'theory, harmonic balance, uncoupled'


def test_one_term_steps_in_where_nothing_is_found(monkeypatch):
    def nothing(oscillator, low, high, isolas):
        return FrequencyResponse(oscillator, low, high, (), (), (), 'nothing')

    monkeypatch.setattr('qzs_rig.prediction.predict.frequency_response', nothing)
    (prediction,) = predict(scenario.of(LOUD))
    assert (prediction.method, prediction.label) == ('single_term', 'theory, one harmonic')


def test_what_is_at_rest_is_not_predicted():
    assert predict(scenario.of({})) == ()
