"""Each task gives at each point what its own tool gives there."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from qzs_rig import scenario
from qzs_rig.campaign import plan
from qzs_rig.campaign.response_tasks import NoMotionError, read_off
from qzs_rig.campaign.runners import evaluate
from qzs_rig.campaign.tasks import TASKS
from qzs_rig.design.proposal import Wish, propose
from qzs_rig.mechanics import statics
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import PAPER_DESIGN
from qzs_rig.run import in_process
from qzs_rig.theory.balance.frequency_response import frequency_response
from qzs_rig.theory.motion.batch import Batch
from qzs_rig.theory.motion.chaos import exponents
from qzs_rig.theory.motion.stroboscope import strobe
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.theory.single_term import folds, onset_omega, peak

QUICK = {
    'run.rate': 125.0,
    'excitation.kind': 'sweep',
    'excitation.frequency_low': 1.0,
    'excitation.frequency_high': 4.0,
    'excitation.duration': 20.0,
    'excitation.ramp': 1.0,
    'excitation.quantity': 'acceleration',
    'excitation.amplitude.vertical': 1.0,
    'sensor.kind': 'noisy',
}


def computed(task, vary, base=None, options=None, **head):
    document = {'campaign': {'task': task, 'chunk': 1000, **head}, 'base': base or {}, 'vary': vary}
    wanted = plan.of(document | {'options': options or {}})
    return wanted, evaluate(wanted, 0)


@pytest.mark.parametrize('name', TASKS)
def test_names_are_told_once(name):
    task = TASKS[name]
    declared = {item.name for item in scenario.parameters()}
    words = [p.name for p in task.inputs] + list(task.columns)
    assert len(set(words)) == len(words)
    assert not declared & {p.name for p in task.inputs}
    assert 'reason' not in words


@pytest.mark.parametrize('falloff', [0, 2])
def test_single_term(falloff):
    base = {'platform.law': 'symmetric', 'amplitude': 0.03}
    zetas = [0.02, 0.07]
    _, part = computed('single_term', {'platform.zeta': zetas}, base, {'falloff': falloff})
    for row, zeta in enumerate(zetas):
        law = (0.0, 4.2, zeta, 0.03, falloff)
        onset, top = onset_omega(*law), peak(*law)
        assert part.columns['onset_omega'][row] == pytest.approx(
            math.nan if onset is None else onset, rel=1e-9, nan_ok=True
        )
        assert part.columns['peak_T'][row] == pytest.approx(
            top.T if top else math.nan, rel=1e-9, nan_ok=True
        )
        edges = folds(*law)
        expected = edges[[0, -1]] if edges.size else [math.nan] * 2
        found = [part.columns[name][row] for name in ('fold_low', 'fold_high')]
        # 1e-6: c1 is zero here but for the rounding of sqrt(3)/2, and folds near 0 feel it
        assert found == pytest.approx(expected, rel=1e-6, nan_ok=True)


def test_statics():
    laws = ['taylor', 'closed_form']
    _, part = computed('statics', {'platform.law': laws}, options={'tolerance': 0.1})
    for row, law in enumerate(laws):
        low, high = statics.soft_range(RESTORING[law], PAPER_DESIGN, 'vertical', 0.1)
        found = part.columns['soft_low'][row], part.columns['soft_high'][row]
        assert found == pytest.approx((low, high), rel=1e-12)
    assert part.columns['tipping_margin'] == pytest.approx([-0.01] * 2, abs=1e-15)


def test_design_tells_wishes_that_cannot_be_had():
    base = {'mass': 50, 'onset': 2.0, 'stroke': 0.1, 'level': 1.0}
    _, part = computed('design', {'zeta': [0.1, 2.0]}, base)
    wanted = propose(Wish(50.0, 2.0, 0.1, 1.0))
    assert part.columns['k1'][0] == wanted.k1
    assert part.code.tolist() == [0, 1]
    assert 'beyond critical damping' in part.reasons[1]
    assert np.isnan(part.columns['k1'][1])


def test_run_is_the_rig_with_a_seed_of_its_own_at_each_point():
    wanted, part = computed('run', {'platform.zeta': [0.2, 0.3]}, QUICK, seed=5)
    points = wanted.between(0, 2)
    seeds = [points.point_seed(row) for row in range(2)]
    assert len(set(seeds)) == 2
    spec = points.spec(1).override({'run.seed': seeds[1]})
    curve = in_process.run(spec).estimate.curves[0]
    assert part.columns['peak_T'][1] == curve.magnitude.max()
    assert part.columns['lost'].tolist() == [0.0, 0.0]


def test_a_seed_given_is_the_seed_of_all_points():
    _, part = computed('run', {'platform.zeta': [0.2]}, QUICK | {'run.seed': 9})
    curve = in_process.run(
        scenario.of(QUICK | {'run.seed': 9, 'platform.zeta': 0.2})
    ).estimate.curves[0]
    assert part.columns['peak_T'][0] == curve.magnitude.max()


def test_a_run_says_what_is_wrong_with_a_point():
    _, part = computed('run', {'dof': ['horizontal']}, QUICK)
    assert 'horizontal is not driven; give excitation.amplitude.horizontal' in part.reasons[1]
    short = QUICK | {'excitation.duration': 0.2, 'excitation.ramp': 0.1}
    _, part = computed('run', {'platform.zeta': [0.2]}, short)
    assert part.code[0] == 1
    diverging = QUICK | {'platform.k1': 1e12, 'platform.law': 'closed_form'}
    _, part = computed('run', {'platform.zeta': [0.2]}, diverging)
    assert 'DivergenceError' in part.reasons[1]


RUNS = {'platform.law': 'closed_form', 'amplitude': 0.6, 'omega': 0.314}


def test_strobe_is_the_stroboscope_whatever_the_chunk():
    vary = {'platform.zeta': {'from': 0.04, 'to': 0.16, 'count': 130}}
    options = {'steps': 18, 'periods': 60}
    _, whole = computed('strobe', vary, RUNS, options, chunk=130)
    wanted, _ = computed('strobe', vary, RUNS, options, chunk=50)
    parts = [evaluate(wanted, number) for number in range(3)]
    for name, column in whole.columns.items():
        np.testing.assert_array_equal(np.concatenate([p.columns[name] for p in parts]), column)
    spec = wanted.between(129, 130).spec(0)
    runs = Batch.of(Oscillator.of(spec, 'vertical', 0.6), 0.314)
    seen = strobe(runs, steps=18, periods=60, keep=0)
    assert whole.columns['T'][129] == abs(seen.transmissibility[0])
    assert whole.columns['w_end'][129] == seen.end[0, 0]


def test_strobe_ends_where_an_independent_integration_does():
    base = RUNS | {'platform.zeta': 0.3, 'w': 0.1, 'velocity': 0.05}
    _, part = computed('strobe', {'omega': [0.314, 0.6]}, _without(base, 'omega'))
    assert part.columns['period'].tolist() == [1.0, 1.0]
    for row, omega in enumerate((0.314, 0.6)):
        oscillator = Oscillator(RESTORING['closed_form'], 'vertical', PAPER_DESIGN, 0.3, 0.6)

        def slope(t, y, omega=omega, oscillator=oscillator):
            push = oscillator.drive(omega) * math.cos(omega * t)
            return y[1], push - 0.6 * y[1] - oscillator.force(y[0])

        end = 2.0 * math.pi / omega * 12
        found = solve_ivp(slope, (0, end), (0.1, 0.05), method='DOP853', rtol=1e-11, atol=1e-13)
        # what the task asks of its steps
        assert part.columns['w_end'][row] == pytest.approx(found.y[0, -1], abs=1e-6)


def test_strobe_tells_the_error_where_checked():
    options = {'checked': True, 'error': 1e-7, 'periods': 100}
    _, part = computed('strobe', {'platform.zeta': [0.1, 0.2]}, RUNS, options)
    assert (part.columns['error'] <= 1e-7).all()


def test_runs_beyond_all_bounds_are_failed_rows():
    for task, periods in (('strobe', 20), ('lyapunov', 40)):
        options = {'steps': 18, 'periods': periods}
        _, part = computed(task, {'amplitude': [0.6, 1e300]}, _without(RUNS, 'amplitude'), options)
        assert part.code.tolist() == [0, 1]
        assert part.reasons[1] == "the motion left the law's domain"


def test_lyapunov_is_the_exponent_of_the_same_run():
    options = {'steps': 18, 'periods': 64, 'before': 10}
    wanted, part = computed('lyapunov', {'platform.zeta': [0.05, 0.1]}, RUNS, options)
    spec = wanted.between(1, 2).spec(0)
    runs = Batch.of(Oscillator.of(spec, 'vertical', 0.6), 0.314)
    found = exponents(runs, steps=18, periods=64, before=10)
    assert part.columns['exponent'][1] == found.value[0]
    assert part.columns['uncertainty'][1] == found.error[0]
    assert part.columns['regular'][1] == found.regular[0]


def test_frf_is_the_frequency_response():
    base = {'platform.law': 'taylor', 'amplitude': 0.02, 'platform.k3_hat': 0.2}
    options = {'low': 0.2, 'high': 0.6, 'harmonics': 5, 'isolas': False}
    _, part = computed('frf', {'platform.zeta': [0.3]}, base, options)
    spec = scenario.of({'platform.law': 'taylor', 'platform.k3_hat': 0.2, 'platform.zeta': 0.3})
    oscillator = Oscillator.of(spec, 'vertical', 0.02)
    found = frequency_response(oscillator, 0.2, 0.6, harmonics=5, isolas=False)
    assert (part.columns['peak_omega'][0], part.columns['peak_T'][0]) == found.peak
    assert part.columns['onset_omega'][0] == max(found.onset_omega, default=math.nan)
    assert part.columns['branches'][0] == len(found.branches)
    assert part.columns['folds'][0] == len(found.folds)


def test_trace_follows_a_branch_through_its_folds():
    base = {'platform.law': 'closed_form', 'amplitude': 0.6, 'platform.zeta': 0.02}
    vary = {'platform.k3_hat': [0.1, 0.12]}
    _, part = computed('trace', vary, base, {'low': 0.25, 'high': 1.0})
    found = [part.columns[name][0] for name in ('fold_low', 'fold_high')]
    assert found == pytest.approx([0.2964333635, 0.3176651784], abs=1e-8)
    assert (part.columns['folds'][0], part.columns['complete'][0]) == (2.0, 1.0)


def test_trace_finds_onset_and_peak_where_frf_does():
    base = {'platform.law': 'closed_form', 'amplitude': 0.1}
    options = {'low': 0.1, 'high': 1.0, 'harmonics': 15}
    vary = {'platform.zeta': [0.1]}
    _, quick = computed('trace', vary, base, options)
    _, exact = computed('frf', vary, base, options | {'isolas': False})
    onset, peak_T = (quick.columns[name] for name in ('onset_omega', 'peak_T'))
    assert onset == pytest.approx(exact.columns['onset_omega'], rel=1e-9)
    # the highest of the points, which lie where steps lead
    assert peak_T == pytest.approx(exact.columns['peak_T'], rel=5e-3)


def test_a_response_without_motion_is_a_failed_row():
    response = SimpleNamespace(branches=(), reason='nothing converged')
    with pytest.raises(NoMotionError, match='nothing converged'):
        read_off(response)


def _without(values, name):
    return {key: value for key, value in values.items() if key != name}
