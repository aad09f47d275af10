"""The stroboscope: order of its method, independent solvers, periods, and what may not matter."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from motion_laws import double_well, rates, ueda
from scipy.integrate import solve_ivp

from qzs_rig.errors import InputError
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import PAPER_DESIGN, Design, fast_rsqrt, rsqrt
from qzs_rig.theory.motion import cycles, kernels
from qzs_rig.theory.motion.batch import Batch
from qzs_rig.theory.motion.kernels import DRIFTS, KICKS, kick_weights, schedule
from qzs_rig.theory.motion.stroboscope import LONGEST, RETURN, history, strobe, strobe_within
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import DOFS

OMEGA = 0.8
WHOLE = {'periods': 12, 'keep': 12, 'early': False}


def figure_13(n=40, omega=0.314, dof='vertical', law='closed_form', **varied):
    own = Oscillator(RESTORING[law], dof, PAPER_DESIGN, 0.07, 0.6)
    return Batch.of(own, omega, **{'zeta': np.linspace(0.0158, 0.158, n), **varied})


def solved(own, omega, periods, start=(0.0, 0.0), phase=0.0):
    """(periods, 2) once a period by DOP853."""
    flashes = 2 * math.pi / omega * np.arange(1, periods + 1)
    how = {'method': 'DOP853', 't_eval': flashes, 'rtol': 1e-12, 'atol': 1e-13}
    return solve_ivp(rates(own, omega, phase), (0, flashes[-1]), start, **how).y.T


def test_drifts_and_kicks_make_one_step():
    assert sum(DRIFTS) == pytest.approx(1.0, abs=1e-15)
    assert sum(KICKS) == pytest.approx(1.0, abs=1e-15)
    assert kick_weights(5).sum() == pytest.approx(5.0, abs=1e-14)
    assert np.array_equal(KICKS, KICKS[::-1])
    assert np.array_equal(DRIFTS, DRIFTS[::-1])


@pytest.mark.parametrize('zeta', [0.0, 0.1])
def test_the_method_is_of_order_six(zeta):
    own = Oscillator(RESTORING['symmetric'], 'vertical', PAPER_DESIGN, zeta, 0.6)
    runs = Batch.of(own, OMEGA, w=[0.1, 0.2, 0.3, 0.5])
    ends = [strobe(runs, steps=n, periods=2, keep=1).end for n in (32, 64, 128)]
    coarse, fine = (np.abs(b - a).max() for a, b in pairwise(ends))
    # Richardson; the next term of a symmetric method is two orders up
    assert math.log2(coarse / fine) == pytest.approx(6.0, abs=0.2)


@pytest.mark.parametrize('law', ['closed_form', 'corrected', 'symmetric', 'geometric'])
def test_w_and_velocity_agree_with_an_independent_solver(law):
    own = Oscillator(RESTORING[law], 'vertical', PAPER_DESIGN, 0.07, 0.3)
    for phase in (0.0, 2.0):
        start = (0.2, -0.1)
        runs = Batch.of(own, OMEGA, w=start[0], velocity=start[1])
        seen = strobe(runs, steps=96, phase=phase, **WHOLE)
        reference = solved(own, OMEGA, 12, start, phase)
        # order 6 at 96 steps leaves 1e-10, DOP853 its 1e-12 a step
        assert seen.w[0] == pytest.approx(reference[:, 0], abs=2e-9)
        assert seen.velocity[0] == pytest.approx(reference[:, 1], abs=2e-9)


@pytest.mark.parametrize('number', range(4), ids=DOFS)
def test_an_unbalanced_load_and_designs_of_their_own(number):
    # k3 > A L0: neither tips
    first = Design.of(1.1, 0.1, 0.8, 0.08)
    designs = [first, Design.of(1.5, 0.5, 0.8, 0.2)]
    both = Design(np.transpose(designs))
    own = Oscillator(RESTORING['corrected'], DOFS[number], both, 0.1, 0.1)
    runs = Batch.of(own, OMEGA, load=0.001)
    seen = strobe(runs, steps=64, **WHOLE)
    for k, design in enumerate(designs):
        one = Oscillator(RESTORING['corrected'], DOFS[number], design, 0.1, 0.1)
        shared = strobe(Batch.of(one, OMEGA, load=0.001), steps=64, **WHOLE)
        # the same sums, regrouped by the compiler
        assert seen.w[k] == pytest.approx(shared.w[0], abs=1e-11)
    loaded = replace(Oscillator(RESTORING['corrected'], DOFS[number], first, 0.1, 0.1), load=0.001)
    assert seen.w[0] == pytest.approx(solved(loaded, OMEGA, 12)[:, 0], abs=1e-8)


def test_energy_stays_without_damping_and_falls_as_it_should_with():
    own = Oscillator(RESTORING['closed_form'], 'vertical', PAPER_DESIGN, 0.0, 0.0)
    seen = strobe(Batch.of(own, OMEGA, w=[0.1, 0.5, 1.0]), steps=64, **WHOLE)
    A, k3, L1, _, a, b = PAPER_DESIGN

    def potential(x):
        """Central spring, suspension, leaf springs and weight of Eq (8)."""
        length = np.sqrt(x * x + a * a)
        leaf = k3 * a * (length - a + L1 * np.arcsinh(x / a))
        return 0.5 * (1.0 + A) * x * x - A * (length - a) + leaf - b * x

    energy = 0.5 * seen.velocity**2 + potential(seen.w)
    start = potential(np.array([0.1, 0.5, 1.0]))
    # symplectic of order 6: the energy swings by the error of a step and does not drift
    assert np.abs(energy - start[:, None]).max() < 1e-9
    linear = Oscillator(RESTORING['linear'], 'vertical', PAPER_DESIGN, 0.1, 0.0)
    seen = strobe(Batch.of(linear, OMEGA, w=1.0), steps=64, **WHOLE)
    t, rate = 2 * math.pi / OMEGA * np.arange(1, 13), math.sqrt(0.1 - 0.1**2)
    exact = np.exp(-0.1 * t) * (np.cos(rate * t) + 0.1 / rate * np.sin(rate * t))
    assert seen.w[0] == pytest.approx(exact, abs=1e-10)


def test_the_interpreter_gives_the_same_figures():
    runs = figure_13(3)
    fast = strobe(runs, steps=18, periods=12, keep=12)
    period = kernels.period_around(runs.law.compilable(runs.number, rsqrt), runs.law.count)
    slow = cycles.found(3, 12, 12)
    rules = cycles.Rules(12, LONGEST, True, RETURN, math.inf)
    table = runs.table, runs.numbers, schedule(18)
    cycles.settle.py_func(period, kernels.block(runs.law.count), *table, rules, slow)
    # the fast root is good to 2e-14, and the motion forgets
    assert slow.points[:, 0] == pytest.approx(fast.w, abs=1e-11)
    assert slow.points[:, 1] == pytest.approx(fast.velocity, abs=1e-11)
    assert slow.figures[:, :2] == pytest.approx(fast.end, abs=1e-11)
    assert slow.figures[:, 2] / 9.0 == pytest.approx(fast.fundamental.real, abs=1e-11)
    assert slow.figures[:, 3] / -9.0 == pytest.approx(fast.fundamental.imag, abs=1e-11)
    assert slow.figures[:, 4] == pytest.approx(fast.low, abs=1e-11)
    assert slow.figures[:, 5] == pytest.approx(fast.high, abs=1e-11)
    assert np.array_equal(slow.cycle, fast.period)
    assert np.array_equal(slow.settled, fast.settled)


def test_the_fast_root_is_good_to_rounding():
    q = np.geomspace(1e-30, 1e30, 1000)
    assert fast_rsqrt(q) * np.sqrt(q) == pytest.approx(1.0, abs=1e-13)


def test_neither_threads_nor_neighbours_change_a_bit():
    runs = figure_13(700)
    one = strobe(runs, steps=18, periods=60, keep=5, workers=1)
    two = strobe(runs, steps=18, periods=60, keep=5, workers=2)
    order = np.random.default_rng(0).permutation(700)
    shuffled = strobe(runs[order], steps=18, periods=60, keep=5, workers=1)
    for name in ('w', 'velocity', 'period', 'settled', 'end', 'fundamental', 'low'):
        assert np.array_equal(getattr(one, name), getattr(two, name)), name
        assert np.array_equal(getattr(one, name)[order], getattr(shuffled, name)), name


def test_an_early_exit_fills_in_what_the_run_would_do():
    runs = figure_13(200)
    whole = strobe(runs, steps=18, early=False)
    early = strobe(runs, steps=18)
    assert np.array_equal(early.period, whole.period)
    assert np.array_equal(early.settled, whole.settled)
    # an exit leaves 1e-8 of the transient by its own estimate, which may be off by a little
    for name in ('w', 'velocity', 'end', 'fundamental'):
        assert np.abs(getattr(early, name) - getattr(whole, name)).max() < 1e-7, name


@pytest.mark.parametrize(
    ('push', 'period'), [(0.20, 1), (0.28, 2), (0.29, 4), (0.37, 5), (0.50, 0), (0.65, 2)]
)
def test_periods_of_the_double_well(push, period):
    """The road to chaos that every textbook shows for x'' + 0.3 x' - x + x³ = push cos 1.2 t."""
    runs = Batch.of(double_well(push), 1.2, w=1.0)
    for early in (True, False):
        seen = strobe(runs, steps=48, periods=1000, keep=40, early=early)
        assert seen.period[0] == period
        if period:
            assert seen.w[0, period:] == pytest.approx(seen.w[0, :-period], abs=1e-6)


def test_the_fundamental_is_that_of_the_harmonic_balance():
    from qzs_rig.theory.balance.harmonic_balance import steady, transmissibility

    own = Oscillator(RESTORING['closed_form'], 'vertical', PAPER_DESIGN, 0.07, 0.6)
    seen = strobe(Batch.of(own, [1.5, 2.0]), steps=48)
    start = np.zeros((2, 41))
    start[:, 1], start[:, 2] = seen.fundamental.real, -seen.fundamental.imag
    found = steady(own, [1.5, 2.0], start)
    assert found.converged.all()
    balanced = transmissibility(own, found.omega, found.coefficients)
    assert seen.transmissibility == pytest.approx(balanced, abs=1e-7)


def test_a_run_that_leaves_its_law_is_lost():
    own = Oscillator(RESTORING['corrected'], 'horizontal_rotation', PAPER_DESIGN, 0.02, 0.9)
    seen = strobe(Batch.of(own, [0.3, 1.0], w=[0.0, 0.9]), steps=32, periods=50, keep=50)
    lost = seen.period < 0
    assert lost.any()
    assert np.isnan(seen.w[lost, -1]).all()
    assert np.isnan(seen.end[lost]).all()
    assert (seen.settled[lost] <= 50).all()


def test_the_history_passes_through_what_the_stroboscope_sees():
    runs = figure_13(1)
    run = history(runs, 12, 18)
    seen = strobe(runs, steps=18, **WHOLE)
    # the exact root here and the fast one there
    assert run.w[18::18] == pytest.approx(seen.w[0], abs=1e-11)
    assert run.velocity[18::18] == pytest.approx(seen.velocity[0], abs=1e-11)
    assert run.tau[-1] == pytest.approx(12 * 2 * math.pi / 0.314)


def test_a_history_ends_where_the_law_does():
    own = Oscillator(RESTORING['corrected'], 'horizontal_rotation', PAPER_DESIGN, 0.02, 0.9)
    run = history(Batch.of(own, 1.0, w=0.9, velocity=1.0), 2, 32)
    assert np.isnan(run.w[-1])
    assert np.isfinite(run.w[0])


def test_the_error_asked_for_is_kept_run_by_run():
    runs = figure_13(60)
    seen = strobe_within(runs, 1e-6, periods=150, keep=100)
    fine = strobe(runs, steps=256, periods=150, keep=100, early=False)
    assert (seen.error <= 1e-6).all()
    # the estimate takes the error for one of order 6: twice it covers the rest
    assert np.abs(seen.w - fine.w).max() < 2e-6


def test_frequencies_far_apart_get_steps_of_their_own():
    own = Oscillator(RESTORING['closed_form'], 'vertical', PAPER_DESIGN, 0.07, 0.6)
    seen = strobe_within(Batch.of(own, [0.1, 0.8, 3.0]), periods=60, keep=20)
    assert seen.steps[0] > seen.steps[1] > seen.steps[2]
    assert (seen.error <= 1e-6).all()


def test_chaos_keeps_no_error_and_says_so():
    seen = strobe_within(Batch.of(ueda(), 1.0, w=[2.5, 2.6]), periods=80, keep=40)
    assert (seen.error > 1e-3).all()


@pytest.mark.parametrize(
    ('varied', 'message'),
    [
        ({'zeta': -0.1}, r'zeta is -0.1; theory needs a number 0 or more'),
        ({'amplitude': np.nan}, r'amplitude is nan; theory needs a number 0 or more'),
        ({'w': np.inf}, r'w is inf; a run needs a finite number'),
        ({'zeta': [0.1, 0.2], 'load': [0.0] * 3}, r'runs of different number: zeta 2'),
    ],
)
def test_runs_are_refused_by_name(varied, message):
    own = Oscillator(RESTORING['closed_form'], 'vertical', PAPER_DESIGN, 0.07, 0.6)
    with pytest.raises(InputError, match=message):
        Batch.of(own, 1.0, **varied)


def test_a_frequency_of_zero_is_refused():
    own = Oscillator(RESTORING['closed_form'], 'vertical', PAPER_DESIGN, 0.07, 0.6)
    with pytest.raises(InputError, match=r'omega is 0.0; a run needs a number above 0'):
        Batch.of(own, 0.0)


@pytest.mark.parametrize(
    ('how', 'message'),
    [
        ({'steps': 0}, '0 steps a period; give 1 or more'),
        ({'steps': 8, 'periods': 0}, '0 periods; give 1 or more'),
        ({'steps': 8, 'periods': 5, 'keep': 6}, '6 of 5 periods kept; give 0 to 5'),
    ],
)
def test_settings_are_refused(how, message):
    with pytest.raises(InputError, match=message):
        strobe(figure_13(1), **how)


def test_an_error_of_nothing_is_refused():
    with pytest.raises(InputError, match=r'error 0; give what w may be off'):
        strobe_within(figure_13(1), 0.0)


def test_a_history_of_nothing_is_refused():
    with pytest.raises(InputError, match='0 periods of 8 steps; give 1 or more of both'):
        history(figure_13(1), 0, 8)
