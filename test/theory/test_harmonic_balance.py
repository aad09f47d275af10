"""The balance, its slopes, its waves and the continuation that walks along it."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
import pytest
from theory_motions import DUFFING, cubic, integrated, state

from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import PAPER_DESIGN
from qzs_rig.theory.balance import continuation, newton
from qzs_rig.theory.balance.basis import Basis, lopsided, mirrored, resized, symmetric
from qzs_rig.theory.balance.bifurcations import zero_between
from qzs_rig.theory.balance.branch import BranchProblem, follow, refined
from qzs_rig.theory.balance.continuation import Ending, Steps, Stop
from qzs_rig.theory.balance.harmonic_balance import (
    PARAMETERS,
    HarmonicBalance,
    steady,
)
from qzs_rig.theory.balance.newton import Point
from qzs_rig.theory.balance.search import describing, motions
from qzs_rig.theory.balance.stability import determinants, floquet
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.theory.single_term import single_term

CLOSED = Oscillator(RESTORING['closed_form'], 'vertical', PAPER_DESIGN, 0.07, 0.3)
BASES = [Basis.full(9), Basis.full(9).doubled(), Basis.odd(9), Basis.odd(9).even()]


@pytest.mark.parametrize('basis', BASES)
def test_waves_and_coefficients_are_inverse(basis):
    # half-odd waves repeat, with the other sign, after the period that is sampled
    back = basis.to_frequency @ basis.to_time
    np.testing.assert_allclose(back, np.eye(len(back)), atol=1e-14)


@pytest.mark.parametrize('basis', BASES)
def test_the_tangent_by_fourier_series(basis):
    stiffness = np.random.default_rng(0).normal(size=(3, basis.samples))
    direct = (basis.to_frequency * stiffness[:, None, :]) @ basis.to_time
    np.testing.assert_allclose(basis.tangent(stiffness), direct, atol=1e-13)


@pytest.mark.parametrize('basis', [Basis.full(7), Basis.odd(7)])
def test_the_derivative_of_waves(basis):
    x = np.random.default_rng(1).normal(size=len(basis.rates))
    share, h = np.array([0.1, 0.7]), 1e-6
    ahead, behind = (basis.waves(share + side) @ x for side in (h, -h))
    # central difference: h² of the seventh harmonic
    slope = (ahead - behind) / (2 * h) / (2 * np.pi)
    np.testing.assert_allclose(basis.waves(share) @ basis.derivative @ x, slope, atol=1e-6)


@pytest.mark.parametrize('parameter', PARAMETERS)
def test_slopes_of_the_balance(parameter):
    unknowns = HarmonicBalance(CLOSED, 9, parameter=parameter, omega=0.7)
    x = np.random.default_rng(2).normal(size=19) * 0.2
    p = math.log(0.8)
    _, jacobian, slope = unknowns.linearised(x, p)
    h = 1e-6
    columns = [
        (unknowns.linearised(x + h * v, p)[0] - unknowns.linearised(x - h * v, p)[0]) / (2 * h)
        for v in np.eye(19)
    ]
    np.testing.assert_allclose(jacobian, np.stack(columns, axis=1), atol=1e-7)
    along = (unknowns.linearised(x, p + h)[0] - unknowns.linearised(x, p - h)[0]) / (2 * h)
    np.testing.assert_allclose(slope, along, atol=1e-7)


def test_residual_and_jacobian_agree_with_the_single_motion():
    balance = HarmonicBalance(CLOSED, 5)
    x = np.random.default_rng(3).normal(size=(4, 11)) * 0.1
    omega = np.array([0.3, 0.6, 1.0, 2.0])
    residual, jacobian = balance.residual(x, omega), balance.jacobian(x, omega)
    for k in range(4):
        alone = balance.slopes(x[k], float(omega[k]))
        np.testing.assert_allclose(residual[k], alone[0], atol=1e-14)
        np.testing.assert_allclose(jacobian[k], alone[1], atol=1e-14)


def test_steady_motions_repeat():
    omega = np.array([0.8, 1.5, 2.5])
    start = np.zeros((3, 31))
    start[:, 1] = -0.3
    found = steady(CLOSED, omega, start)
    assert found.converged.all()
    for w, x in zip(found.omega, found.coefficients, strict=True):
        # fifteen harmonics leave 1e-7 of a motion of 2 L20
        end, _ = integrated(CLOSED, w, state(x, w))
        np.testing.assert_allclose(end, state(x, w), atol=1e-6)


def test_one_harmonic_motions_are_all_there():
    own = Oscillator(RESTORING['symmetric'], 'vertical', PAPER_DESIGN, 0.07, 1 / 12)
    expected = single_term(0.0, 4.2, 0.07, 1 / 12, [0.5]).W[0]
    found = motions(own, describing(own), 0.5)
    W = np.hypot(found[:, 1], found[:, 2])
    # levels of the table are 5 % apart, the middle of them hit by interpolation
    assert all(np.min(np.abs(W / w - 1)) < 0.02 for w in expected)
    np.testing.assert_allclose(found[:, 0], 0.0, atol=1e-12)


def test_symmetry_of_laws_and_motions():
    assert symmetric(Oscillator(RESTORING['corrected'], 'horizontal', PAPER_DESIGN, 0.1, 0.1))
    assert not symmetric(CLOSED)
    x = np.arange(1.0, 8.0)
    assert mirrored(mirrored(x)).tolist() == x.tolist()
    assert lopsided(np.array([0.0, 1.0, 2.0, 0.0, 0.0, 3.0, 4.0])) == 0.0
    assert lopsided(np.array([1.0, 0.0, 0.0])) == 1.0


def test_odd_harmonics_are_enough_for_an_odd_law():
    own = Oscillator(cubic(1.0, 0.5), 'vertical', PAPER_DESIGN, 0.05, 0.4)
    x = np.zeros(23)
    x[1] = -0.4
    whole, odd = (refined(_problem(own, 2.0, x, 1.0, 3.0, odd)) for odd in (False, True))
    n = min(len(whole), len(odd))
    np.testing.assert_allclose(whole[:n], odd[:n], atol=1e-9)
    full, half = (
        floquet(own, np.array([2.0]), odd[None], odd=way).multipliers[0] for way in (False, True)
    )
    np.testing.assert_allclose(np.sort(full), np.sort(half), atol=1e-6)


def test_hill_and_floquet_have_the_same_sign():
    path = follow(_problem(DUFFING, 1.5, _start(DUFFING, 1.5), 0.9, 1.6))
    found = floquet(DUFFING, path.value, path.coefficients)
    signs = [
        determinants(DUFFING, w, x) for w, x in zip(path.value, path.coefficients, strict=True)
    ]
    clear = np.abs(found.same) > 1e-6
    assert (np.sign([same for same, _ in signs]) == np.sign(found.same))[clear].all()
    assert (np.sign([other for _, other in signs]) == np.sign(found.other)).all()


def test_a_closed_path_ends_where_it_began():
    class Circle:
        def linearised(self, x, p):
            left = np.array([x[0] ** 2 + p**2 - 1, x[1] - 1])
            return left, np.diag([2 * x[0], 1.0]), np.array([2 * p, 0.0])

    first = newton.start(Circle(), np.array([1.0, 1.0]), 0.0, 1.0)
    path = continuation.follow(Circle(), first, -2.0, 2.0)
    assert path.stop is Stop.CLOSED
    radius = [math.hypot(q.x[0], q.p) for q in path.points]
    np.testing.assert_allclose(radius, 1.0, atol=1e-9)
    assert min(q.x[0] for q in path.points) < -0.99


def test_a_path_does_not_jump_to_its_neighbour():
    """x² = p² + 1e-5: two branches that nearly cross."""

    class Crossing:
        def linearised(self, x, p):
            gap = np.array([x[0] ** 2 - p**2 - 1e-5])
            return gap, np.array([[2 * x[0]]]), np.array([-2 * p])

    x = np.array([math.sqrt(1 + 1e-5)])
    first = newton.start(Crossing(), x, -1.0, 1.0)
    path = continuation.follow(Crossing(), first, -1.0, 1.0)
    assert path.stop is Stop.RANGE
    assert all(q.x[0] > 0 for q in path.points)
    assert path.points[-1].p == 1.0


def test_a_path_that_ends_says_why():
    class Cliff:
        def linearised(self, x, p):
            slope = 1.0 if p < 0.5 else math.nan
            return np.array([x[0] - p]), np.array([[slope]]), np.array([-1.0])

    first = newton.start(Cliff(), np.array([0.0]), 0.0, 1.0)
    path = continuation.follow(Cliff(), first, -1.0, 1.0)
    assert path.stop is Stop.STEP
    assert path.points[-1].p == pytest.approx(0.5, abs=1e-6)
    short = continuation.follow(Cliff(), first, -1.0, 1.0, steps=Steps(most=3))
    assert str(short.ending) == '3 points'


def test_a_zero_between_two_points():
    class Parabola:
        def linearised(self, x, p):
            gap = np.array([p - x[0] ** 2 if p < 2.0 else math.nan])
            return gap, np.array([[-2 * x[0]]]), np.array([1.0])

    def point(x):
        return Point(np.array([x]), x * x, np.zeros(2), 1.0)

    equations = Parabola()
    fold = zero_between(equations, point(-0.4), point(0.7), lambda q: q.tangent[-1])
    assert fold.p == pytest.approx(0.0, abs=1e-12)
    third = zero_between(equations, point(0.2), point(0.7), lambda q: q.x[0] - 1 / 3)
    assert third.x[0] == pytest.approx(1 / 3, abs=1e-12)
    assert zero_between(equations, point(0.2), point(0.7), lambda q: 1.0 + q.x[0]) is None
    assert zero_between(equations, point(1.3), point(1.6), lambda q: q.x[0] - 1.5) is None


def test_resized():
    x = np.arange(5.0)
    assert resized(resized(x, 4), 2).tolist() == x.tolist()
    assert resized(x, 1).tolist() == [0.0, 1.0, 2.0]


def test_a_start_that_leads_nowhere():
    nowhere = _problem(CLOSED, 0.05, np.full(15, math.nan), 0.02, 1.0)
    assert refined(nowhere) is None
    path = follow(nowhere)
    assert path.ends == (Ending(Stop.START),) * 2
    assert path.value.tolist() == [0.05]


def _problem(own, omega, x, low, high, odd=False):
    return BranchProblem(partial(HarmonicBalance, own, odd=odd), omega, x, low, high)


def _start(own, omega):
    x = np.zeros(15)
    x[1] = -own.drive(omega) / omega**2
    return x
