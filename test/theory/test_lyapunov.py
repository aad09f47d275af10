"""Lyapunov exponents: Ueda's attractor, linear theory, Floquet's multipliers."""

from __future__ import annotations

import math

import numpy as np
import pytest
from motion_laws import rates, ueda
from scipy.integrate import solve_ivp

from qzs_rig.errors import InputError
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import PAPER_DESIGN, rsqrt
from qzs_rig.theory.motion import kernels
from qzs_rig.theory.motion.batch import Batch
from qzs_rig.theory.motion.chaos import exponents
from qzs_rig.theory.motion.kernels import schedule
from qzs_rig.theory.motion.stroboscope import strobe
from qzs_rig.theory.oscillator import Oscillator


def test_the_exponent_of_ueda():
    """x'' + 0.05 x' + x³ = 7.5 cos t: 0.1034 (issue 4)."""
    start = np.random.default_rng(1).uniform(-3.0, 3.0, (2, 1024))
    runs = Batch.of(ueda(), 1.0, w=start[0], velocity=start[1])
    found = exponents(runs, steps=24, periods=2000, before=100)
    mean, error = found.mean
    assert mean == pytest.approx(0.1034, abs=0.0005)
    assert error < 1.5e-4
    assert found.chaotic.all()
    # batch means within a run must tell the scatter between runs
    assert found.error.mean() == pytest.approx(found.value.std(ddof=1), rel=0.15)


def test_a_linear_oscillator_has_minus_zeta_or_its_slower_root():
    for zeta in (0.05, 0.6):
        own = Oscillator(RESTORING['linear'], 'vertical', PAPER_DESIGN, zeta, 0.3)
        found = exponents(Batch.of(own, 0.7), steps=48, periods=800, before=50)
        slower = -zeta + math.sqrt(max(zeta**2 - 0.1, 0.0))
        # a turning disturbance swings by a few 1/t
        assert found.value[0] == pytest.approx(slower, abs=5e-4)
        assert found.regular[0]


def test_the_exponent_of_a_cycle_is_that_of_its_larger_multiplier():
    own, omega = ueda(1.0), 1.0
    seen = strobe(Batch.of(own, omega), steps=64, periods=2000, keep=0)
    assert seen.period[0] == 1
    slope = rates(own, omega)

    def varied(t, y):
        stiffness = float(own.stiffness(y[0]))
        turned = [y[4], y[5], -stiffness * y[2] - 0.05 * y[4], -stiffness * y[3] - 0.05 * y[5]]
        return [*slope(t, y[:2]), *turned]

    y = [*seen.end[0], 1.0, 0.0, 0.0, 1.0]
    end = solve_ivp(varied, (0, 2 * math.pi), y, 'DOP853', rtol=1e-12, atol=1e-13).y[:, -1]
    multipliers = np.linalg.eigvals(end[2:].reshape(2, 2))
    # Liouville: what is left of an area after a period
    assert np.prod(multipliers).real == pytest.approx(math.exp(-0.05 * 2 * math.pi), abs=1e-9)
    floquet = math.log(np.abs(multipliers).max()) / (2 * math.pi)
    start = {'w': seen.end[0, 0], 'velocity': seen.end[0, 1]}
    found = exponents(Batch.of(own, omega, **start), steps=64, periods=3000, before=20)
    assert found.value[0] == pytest.approx(floquet, abs=3e-4)


def test_the_interpreter_gives_the_same_exponents():
    own = Oscillator(RESTORING['closed_form'], 'vertical', PAPER_DESIGN, 0.07, 0.6)
    runs = Batch.of(own, 0.314, zeta=[0.05, 0.1])
    how = runs.table, runs.numbers, schedule(16), 1
    fast, slow = ((np.empty((2, 5)), np.empty((2, 2))) for _ in range(2))
    kernels.grow(kernels.advancing(runs.law, 0), kernels.block(runs.law.count, 2), *how, *fast)
    period = kernels.period_around(runs.law.compilable(0, rsqrt), runs.law.count)
    kernels.grow.py_func(period, kernels.block(runs.law.count, 2), *how, *slow)
    # rounding over the base of the difference, 1e-16 / 1e-5, and twenty times that along the run
    assert slow[0].mean(axis=1) == pytest.approx(fast[0].mean(axis=1), abs=1e-8)
    assert slow[1] == pytest.approx(fast[1], abs=1e-11)


def test_a_lost_run_has_no_exponent():
    own = Oscillator(RESTORING['corrected'], 'horizontal_rotation', PAPER_DESIGN, 0.02, 0.9)
    found = exponents(Batch.of(own, 1.0, w=0.9, velocity=1.0), steps=32, periods=32, before=0)
    assert np.isnan(found.value[0])
    assert not found.chaotic[0]
    assert not found.regular[0]
    assert np.isnan(found.mean).all()


@pytest.mark.parametrize(
    ('how', 'message'),
    [
        ({'steps': 0}, '0 steps; an exponent needs 1 or more'),
        ({'steps': 9, 'periods': 31}, '31 periods; an exponent needs 32 or more'),
        ({'steps': 9, 'before': -1}, '-1 periods before; give 0 or more'),
    ],
)
def test_settings_are_refused(how, message):
    with pytest.raises(InputError, match=message):
        exponents(Batch.of(ueda(), 1.0), **how)
