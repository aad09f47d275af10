"""What a fit says of platforms that something else has measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from qzs_rig import scenario
from qzs_rig.errors import InputError
from qzs_rig.identification.fit_report import fit_text
from qzs_rig.identification.identify import advice, identify
from qzs_rig.identification.intervals import Interval
from qzs_rig.identification.points import by_dof, measured
from qzs_rig.identification.unknowns import DEFAULT
from qzs_rig.run import in_process


@pytest.mark.parametrize('lane', [0, 1])
def test_noise_free_curves_give_the_platform_back(bench, lane):
    found = identify(bench.spec, [bench.points(lane)], DEFAULT)
    # Runge-Kutta and settling of the measurement: 1e-5; of the trim, in kg, by its weak effect
    assert found.fit.values == pytest.approx(bench.truth[lane], rel=1e-4, abs=1e-3)
    assert found.cautions == ()
    assert found.advice.action == ('remove', 'add')[lane]
    assert found.advice.grams == pytest.approx(-1e3 * bench.truth[lane, 2], abs=1.0)
    upper = found.fit.responses[0].upper
    assert upper.any() and not upper.all()


def test_intervals_hold_the_truth(bench):
    """Of 9 intervals of 95 % fewer than 7 hold it once in 100 times; benchmarks/ counts 900."""
    held = 0
    for seed in range(3):
        points = bench.points(seed % 2, 0.01, seed, std=seed % 2 == 0)
        found = identify(bench.spec, [points], DEFAULT)
        pairs = zip(found.intervals, bench.truth[seed % 2], strict=True)
        held += sum(limit.low <= true <= limit.high for limit, true in pairs)
    assert held >= 7


def test_magnitudes_alone_do(bench):
    found = identify(bench.spec, [bench.points(0, 0.003, 1, phase=False)], DEFAULT)
    pairs = zip(found.intervals, bench.truth[0], strict=True)
    assert any('without phase' in text for text in found.cautions)
    # one seed, three intervals of 95 %, told over all solutions that fit
    assert all(limit.low <= true <= limit.high for limit, true in pairs)


def test_advice_says_which_way():
    def limit(low, high, determined=True):
        return Interval(low, high, 0.1, determined, 'linear')

    heavy = advice(0.3, limit(0.25, 0.35))
    assert (heavy.action, heavy.low, heavy.high) == ('remove', -350.0, -250.0)
    assert heavy.text == 'remove 300 g (95 %: 250 to 350 g)'
    assert advice(-0.3, limit(-0.35, -0.25)).text == 'add 300 g (95 %: 250 to 350 g)'
    assert advice(0.1, limit(-0.1, 0.3)).action == 'leave'
    assert advice(0.3, limit(0.1, 0.5, False)).action == 'unknown'


def test_given_deviations_are_judged_and_widened(bench):
    balanced = bench.spec.override({'platform.payload_trim': 0.3})
    honest = identify(balanced, [bench.points(0, 0.01, 3, std=True)], DEFAULT[:2])
    # 40 readings less 2 parameters: chi-square over its freedom is 1 ± 0.23
    assert honest.reduced_chi_square == pytest.approx(1.0, abs=0.7)
    points = bench.points(0, 0.01, 3, std=True)
    boasting = identify(balanced, [replace(points, std=points.std / 3.0)], DEFAULT[:2])
    assert any('widened' in text for text in boasting.cautions)
    assert boasting.known.std == pytest.approx(honest.known.std, rel=0.5)


def test_a_parameter_at_its_bound_is_named(bench):
    # looked for down to a thirtieth of 2.6, which is above the true 0.08
    far = {'platform.zeta': 2.6, 'platform.A': 1.1, 'platform.payload_trim': 0.3}
    found = identify(bench.spec.override(far), [bench.points(0, 0.01)], ('platform.zeta',))
    assert found.fit.values == pytest.approx([2.6 / 30.0], rel=1e-4)
    assert any('platform.zeta ended at a bound' in text for text in found.cautions)


def test_what_the_points_do_not_determine_is_named(bench):
    ratios = bench.spec.override(
        {'platform.A': 1.11, 'platform.k3_hat': 0.1, 'platform.zeta': 0.08}
    )
    # frequency knows k1/m; the trim of lane 2 is nothing, so no weight tells k1 by itself
    found = identify(ratios, [bench.points(2, 0.003)], ('platform.k1', 'platform.m'))
    assert not any(limit.determined for limit in found.intervals)
    assert any('do not determine platform.k1, platform.m' in text for text in found.cautions)
    best, other = found.known.directions
    assert best.weights[0] == pytest.approx(-best.weights[1], rel=0.02)
    assert best.std < 0.01 and other.std > 1.0
    assert found.known.correlation[0, 1] > 0.999
    assert 'not determined' in fit_text(found)
    assert 'Combinations' in fit_text(found)


def test_a_stepped_run_of_the_rig_is_found_again():
    true = {'platform.zeta': 0.03, 'platform.A': 1.11, 'platform.payload_trim': 0.3}
    start = scenario.load('stepped_sine')
    spec = start.override(true)
    parts = by_dof(measured(in_process.run(spec).estimate, spec), None)
    found = identify(start, parts, tuple(true))
    for limit, value in zip(found.intervals, true.values(), strict=True):
        assert limit.low <= value <= limit.high
    assert found.advice.action == 'remove'


def test_the_lag_of_a_sweep_is_taken_off():
    true = {'platform.zeta': 0.03, 'platform.A': 1.11}
    start = scenario.load('vertical_sweep').override({'platform.payload_trim': 0.3})
    spec = start.override(true)
    parts = by_dof(measured(in_process.run(spec).estimate, spec), None)
    found = identify(start, parts, tuple(true))
    still = [replace(points, chirp=np.zeros(len(points))) for points in parts]
    biased = identify(start, still, tuple(true))
    error, bias = (abs(item.fit.values[0] / 0.03 - 1.0) for item in (found, biased))
    # first order in the rate is left out to its square: the lag is up to 10 %
    assert error < 0.002 < bias
    assert any('ISO 7626-2' in text for text in found.cautions)


def test_refusals(bench):
    points = bench.points()
    for names, said in (
        (('platform.L0_hat',), 'moves none of the measured points'),
        (('platform.lw',), 'unknown parameter'),
        (('platform.law',), 'unknown parameter'),
        ((), 'nothing to fit'),
        (('platform.A', 'platform.A'), 'twice'),
        (('platform.A', 'platform.k2'), 'same thing twice'),
    ):
        with pytest.raises(InputError, match=said):
            identify(bench.spec, [points], names)
    still = scenario.of({})
    with pytest.raises(InputError, match=r'excitation.amplitude.vertical is 0'):
        identify(still, [points], DEFAULT)
    undamped = bench.spec.override({'platform.zeta': 0.0})
    with pytest.raises(InputError, match='no damping to start from'):
        identify(undamped, [points], ('platform.A',))
    loud = bench.spec.override({'excitation.amplitude.vertical': 0.001})
    with pytest.raises(InputError, match='no branch of the platform passes near'):
        identify(loud, [points], ('platform.payload_trim',))
    few = points.take(np.arange(20) < 4)
    names = ('platform.zeta', 'platform.A', 'platform.k3_hat', 'platform.L1_hat')
    with pytest.raises(InputError, match=r'cannot fix 4 parameters|no branch'):
        identify(bench.spec, [replace(few, phase=few.phase * np.nan)], names)


def test_points_that_cannot_tell_are_refused(bench):
    points = bench.points()
    with pytest.raises(InputError, match='no measured points'):
        by_dof([], None)
    with pytest.raises(InputError, match="no measured points of 'horizontal'"):
        by_dof([points], 'horizontal')
    with pytest.raises(InputError, match='3 usable points'):
        by_dof([points.take(np.arange(20) < 3)], None)
    with pytest.raises(InputError, match='one frequency'):
        by_dof([replace(points, frequency_hz=np.full(20, 2.0))], None)
    with pytest.raises(InputError, match='the same transmissibility'):
        by_dof([replace(points, magnitude=np.ones(20))], None)
