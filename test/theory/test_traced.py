"""The traced curve against Newton at each frequency, integration by scipy, published folds, and the
same templates in the interpreter."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from qzs_rig.errors import InputError
from qzs_rig.mechanics.design import PAPER_DESIGN
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.polynomial import polynomial
from qzs_rig.theory.balance.harmonic_balance import steady
from qzs_rig.theory.oscillator import Oscillator, oscillator
from qzs_rig.theory.tracer import curve_kernel
from qzs_rig.theory.tracer.traced import REASONS, Traced, trace, trace_many
from qzs_rig.units import DOFS


def stiffening(design, w):
    return w + 0.1 * w * w * w


DUFFING = polynomial(
    'duffing',
    'Krack and Gross 2019, NLvib example 01',
    (stiffening,) * 4,
    lambda design: ((1.0, 0.0, 0.1),) * 4,
    weighted=False,
)
EXAMPLE = Oscillator(DUFFING, 'vertical', PAPER_DESIGN, 0.025, 0.18, falloff=2)
EVERY = [(law, dof) for law in RESTORING for dof in DOFS]


def turns(curve: Traced) -> np.ndarray:
    """Places where the frequency turns back."""
    rise = np.diff(curve.omega) > 0
    return np.flatnonzero(rise[1:] != rise[:-1]) + 1


def fold(own: Oscillator, curve: Traced, place: int) -> float:
    """Frequency at a turn: the vertex of parabolas through ever closer points of a finer curve."""
    x, omega = curve.coefficients[place - 2], float(curve.omega[place - 2])
    rising = bool(curve.omega[place - 1] > omega)
    fine = trace(
        own,
        0.9 * curve.omega.min(),
        1.1 * curve.omega.max(),
        harmonics=curve.coefficients.shape[1] // 2,
        start=x,
        omega=omega,
        direction='up' if rising else 'down',
        step=0.01,
        miss=1e-6,
        points=600,
    )
    k = turns(fine)[0]
    near = slice(k - 2, k + 3)
    # over a coordinate that passes through the fold; five points: a quartic, far below 1e-7
    s = np.linalg.norm(fine.coefficients[near] - fine.coefficients[k], axis=1)
    s *= np.sign(np.arange(-2, 3))
    quartic = np.polynomial.Polynomial.fit(s, fine.omega[near], 4)
    roots = quartic.deriv().roots()
    real = roots[np.abs(roots.imag) < 1e-9].real
    return float(quartic(real[np.argmin(np.abs(real))]))


def monodromy(own: Oscillator, omega: float, x: np.ndarray) -> np.ndarray:
    """Integrated by scipy along the motion (2H + 1,)."""
    order = np.arange(1, len(x) // 2 + 1)

    def rate(t, y):
        angle = order * omega * t
        k = own.stiffness(x[0] + x[1::2] @ np.cos(angle) + x[2::2] @ np.sin(angle))
        return [y[1], -2 * own.zeta * y[1] - k * y[0], y[3], -2 * own.zeta * y[3] - k * y[2]]

    y = solve_ivp(rate, (0, 2 * np.pi / omega), [1, 0, 0, 1], 'DOP853', rtol=1e-10, atol=1e-12).y
    return y[:, -1].reshape(2, 2).T


@pytest.mark.parametrize(('law', 'dof'), EVERY)
def test_every_point_is_a_motion_that_newton_finds(law, dof):
    own = oscillator(law, dof, PAPER_DESIGN, 0.05, 0.1)
    curve = trace(own, 0.4, 3.0, harmonics=15)
    assert curve.reason in (REASONS[0], REASONS[1])
    assert len(curve.omega) > 20
    found = steady(own, curve.omega, curve.coefficients, tolerance=1e-11)
    # Where the slope at fixed frequency is nearly singular neither is sharp: folds, and w ~ 0.
    away = np.abs(1 + curve.determinants - curve.traces) > 1e-3
    assert np.all(found.converged[away])
    gap = np.abs(found.coefficients - curve.coefficients).max(axis=1)
    assert gap[away].max() < 1e-9


@pytest.mark.parametrize('direction', ['down', 'up'])
@pytest.mark.parametrize(
    ('law', 'dof'),
    [('closed_form', 'vertical'), ('taylor', 'vertical'), ('corrected', 'horizontal')],
)
def test_multipliers_are_those_of_integration(law, dof, direction):
    own = oscillator(law, dof, PAPER_DESIGN, 0.07, 0.1)
    curve = trace(own, 0.15, 2.5, harmonics=9, direction=direction)
    for k in range(0, len(curve.omega), 12):
        expected = monodromy(own, curve.omega[k], curve.coefficients[k])
        # Numerov's and Richardson's error at the finest grid that `RESOLVED` asks for
        assert curve.traces[k] == pytest.approx(np.trace(expected), abs=3e-6)
        size = np.abs(np.linalg.eigvals(expected)).max()
        assert np.abs(curve.multipliers[k]).max() == pytest.approx(size, rel=1e-3)
        if abs(size - 1) > 1e-3:
            assert curve.stable[k] == (size < 1)


@pytest.mark.parametrize(
    ('own', 'low', 'high', 'harmonics', 'folds', 'tolerance'),
    [
        # Published to ten digits; the polynomial through the turn is what limits here.
        (EXAMPLE, 0.5, 2.0, 7, [1.1157002518, 1.2696019555], 1e-7),
        (
            oscillator('closed_form', 'vertical', PAPER_DESIGN, 0.02, 0.6),
            0.25,
            2.0,
            31,
            [0.2964333635, 0.3176651784],
            1e-7,
        ),
    ],
    ids=['duffing', 'closed_form'],
)
def test_folds_are_the_published_ones(own, low, high, harmonics, folds, tolerance):
    curve = trace(own, low, high, harmonics=harmonics)
    assert curve.reason == REASONS[0]
    assert curve.omega[[0, -1]].tolist() == [high, low]
    found = sorted(fold(own, curve, k) for k in turns(curve))
    assert found == pytest.approx(folds, abs=tolerance)


def isolated() -> tuple[Oscillator, float, np.ndarray]:
    """A motion on the closed branch of `taylor`, by integration from within its basin."""
    own, omega, n = oscillator('taylor', 'vertical', PAPER_DESIGN, 0.07, 0.6), 0.3, 256

    def rate(t, y):
        force = own.force(y[0])
        return [y[1], own.drive(omega) * np.cos(omega * t) - 2 * own.zeta * y[1] - force]

    t = 2 * np.pi / omega * np.arange(n) / n
    w = solve_ivp(rate, (0, t[-1]), [0.233, 0.1345], 'DOP853', t, rtol=1e-9).y[0]
    wave = np.fft.rfft(w)[:16] / n
    x = np.zeros(31)
    x[0], x[1::2], x[2::2] = wave[0].real, 2 * wave[1:].real, -2 * wave[1:].imag
    return own, omega, x


@pytest.mark.parametrize('miss', [3e-3, 1e-3, 3e-4])
@pytest.mark.parametrize('direction', ['down', 'up'])
def test_a_closed_branch_closes_beside_another(direction, miss):
    """Both its turns pass so close by the main branch that a careless step ends up there."""
    own, omega, x = isolated()
    curve = trace(own, 0.1, 2.0, harmonics=15, start=x, omega=omega, direction=direction, miss=miss)
    assert curve.reason == REASONS[2]
    np.testing.assert_array_equal(curve.coefficients[0], curve.coefficients[-1])
    assert curve.omega[0] == curve.omega[-1] == omega
    assert len(turns(curve)) == 2
    found = sorted(fold(own, curve, k) for k in turns(curve))
    # the bend at the upper one is too sharp for the polynomial to give more
    assert found == pytest.approx([0.2071890982, 0.4724070372], abs=1e-6)


@pytest.mark.parametrize(
    ('law', 'dof', 'direction'),
    [
        ('closed_form', 'vertical', 'down'),
        ('symmetric', 'vertical', 'up'),
        ('geometric', 'horizontal_rotation', 'down'),
    ],
)
def test_the_interpreter_draws_the_same_curve(law, dof, direction):
    own = oscillator(law, dof, PAPER_DESIGN, 0.07, 0.05)
    fast, slow = (
        trace(own, 0.3, 1.5, harmonics=3, direction=direction, kernel=kernel)
        for kernel in ('numba', 'python')
    )
    assert fast.reason == slow.reason
    # Sums in another order; a difference of rounding grows along the curve, and at folds.
    np.testing.assert_allclose(fast.omega, slow.omega, rtol=1e-9)
    np.testing.assert_allclose(fast.coefficients, slow.coefficients, atol=1e-9)
    np.testing.assert_allclose(fast.traces, slow.traces, atol=1e-8)


def test_linear_response_is_the_closed_form():
    own = oscillator('linear', 'vertical', PAPER_DESIGN, 0.05, 0.1)
    curve = trace(own, 0.1, 3.0, harmonics=3)
    x = curve.omega**2
    w = 0.1 * x / (0.1 - x + 2j * 0.05 * curve.omega)
    np.testing.assert_allclose(
        curve.coefficients[:, 1] - 1j * curve.coefficients[:, 2], w, atol=1e-10
    )
    T = 2 * np.pi / curve.omega
    expected = 2 * np.exp(-0.05 * T) * np.cos(np.sqrt(0.1 - 0.05**2) * T)
    np.testing.assert_allclose(curve.traces, expected, atol=1e-7)
    assert curve.stable.all()


def test_both_directions_draw_the_same_branch():
    down, up = (trace(EXAMPLE, 0.5, 2.0, direction=direction) for direction in ('down', 'up'))
    assert (down.reason, up.reason) == (REASONS[0], REASONS[1])
    there = steady(EXAMPLE, [0.7, 1.2, 1.6], down.coefficients[[-1, 0, 0]])
    for curve in (down, up):
        assert len(turns(curve)) == 2
        for omega, x in zip(there.omega, there.coefficients, strict=True):
            passed = (curve.omega[:-1] - omega) * (curve.omega[1:] - omega) <= 0
            assert np.abs(curve.coefficients[:-1][passed] - x).max(axis=1).min() < 0.3


def test_more_points_where_they_are_asked_for():
    few, many = (trace(EXAMPLE, 0.5, 2.0, step=step, miss=1e-4) for step in (0.1, 0.02))
    assert len(many.omega) > 2 * len(few.omega)


@pytest.mark.parametrize(('zeta', 'amplitude'), [(0.001, 0.7), (0.05, 0.9), (0.05, 0.95)])
def test_a_curve_ends_where_its_law_does(zeta, amplitude):
    own = oscillator('corrected', 'horizontal_rotation', PAPER_DESIGN, zeta, amplitude)
    curve = trace(own, 0.1, 1.0)
    assert curve.reason == REASONS[4]
    assert curve.omega[-1] > 0.1
    order = np.arange(1, 8)
    angle = np.outer(np.linspace(0, 2 * np.pi, 500), order)
    x = curve.coefficients[-1]
    w = x[0] + np.cos(angle) @ x[1::2] + np.sin(angle) @ x[2::2]
    # the domain is looked at in 32 samples a period: cos(π/32) of a peak that falls between
    assert 0.97 < np.abs(w).max() < 1.005


def test_no_motion_to_begin_with_is_told():
    own = oscillator('closed_form', 'horizontal_rotation', PAPER_DESIGN, 0.05, 1.5)
    curve = trace(own, 0.5, 2.0)
    assert curve.reason == REASONS[3]
    assert curve.coefficients.shape == (0, 15)
    assert curve.multipliers.shape == (0, 2)


def test_points_can_run_out():
    curve = trace(EXAMPLE, 0.5, 2.0, points=10)
    assert curve.reason == REASONS[6]
    assert len(curve.omega) == 10


def test_many_are_each_traced():
    own = [oscillator('symmetric', 'vertical', PAPER_DESIGN, z, 0.03) for z in (0.05, 0.07, 0.1)]
    for one, each in zip(own, trace_many(own, 0.1, 2.0, harmonics=5), strict=True):
        np.testing.assert_array_equal(each.omega, trace(one, 0.1, 2.0, harmonics=5).omega)


@pytest.mark.parametrize(
    ('change', 'message'),
    [
        ({'low': 2.0, 'high': 1.0}, 'the band is 2 to 1; give one that rises'),
        ({'harmonics': 0}, 'harmonics is 0; give 1 or more'),
        ({'direction': 'left'}, "direction is 'left'; give one of down, up"),
        ({'kernel': 'gpu'}, "kernel is 'gpu'; give one of auto, numba, python"),
        ({'omega': 5.0}, 'omega is 5; give one within the band 0.5 to 2'),
    ],
)
def test_refuses(change, message):
    with pytest.raises(InputError, match=message):
        trace(EXAMPLE, **{'low': 0.5, 'high': 2.0, **change})


def test_refuses_rest():
    with pytest.raises(InputError, match='amplitude is 0: nothing moves'):
        trace(oscillator('symmetric', 'vertical', PAPER_DESIGN, 0.05, 0.0), 0.5, 2.0)


def test_without_numba_the_interpreter_takes_over(monkeypatch):
    monkeypatch.setitem(sys.modules, 'numba', None)
    curve_kernel.in_numba.cache_clear()
    own = oscillator('symmetric', 'vertical', PAPER_DESIGN, 0.07, 0.03)
    assert trace(own, 0.8, 1.0, harmonics=1).reason == REASONS[0]
    with pytest.raises(InputError, match=r"needs numba; pip install 'qzs_rig\[fast\]'"):
        trace(own, 0.8, 1.0, kernel='numba')
