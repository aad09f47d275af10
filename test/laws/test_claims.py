"""Claims C1 to C6, each recomputed from closed forms that share nothing with the checks."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from qzs_rig.claims import CLAIMS, STATIC
from qzs_rig.claims.paper import document, table, verdicts

A, K3, L1, HALF = 1.1, 0.1, math.sqrt(0.75), 0.5


@pytest.fixture(scope='module')
def found():
    return verdicts(CLAIMS)


def test_every_claim_says_what_and_how(found):
    assert list(found) == list(CLAIMS)
    for item in document(found):
        assert item['verdict'] in {'reproduced', 'not reproduced'}
        assert item['figures'] and item['how'] and item['claim']
        assert all(isinstance(value, float) for value in item['figures'].values())
    assert len(table(found).rows) == len(CLAIMS)


def test_c1_range_is_the_nearer_root_of_9(found):
    figures = found['C1'].figures
    assert found['C1'].text == 'reproduced'
    reached = []
    for k3, name in ((0.1, '1.1'), (0.5, '1.5'), (1.0, '2')):
        A = (1.0 + k3) * HALF / (1.0 - HALF)
        x = -figures[f'|K| <= 0.05 up to, A = {name}']
        cube = (x * x + HALF**2) ** 1.5
        K = 1.0 + A + (-A * HALF**2 + k3 * HALF * (HALF**2 - x * L1)) / cube
        assert figures[f'stiffness at 0, A = {name}'] == pytest.approx(0.0, abs=1e-12)
        assert abs(K - 0.05) < 1e-9
        reached.append(-x)
    assert reached == sorted(reached, reverse=True)


def test_c2_is_zero_by_a_sign(found):
    assert found['C2'].text == 'not reproduced'
    assert list(found['C2'].figures.values()) == pytest.approx([0.0, 2.0 * A * HALF**2], abs=1e-12)


def test_c3_vertical_deviation(found):
    def exact(x):
        root = math.sqrt(x * x + HALF**2)
        return x + A * x * (1.0 - 1.0 / root) + K3 * HALF / root * (x + L1) - K3 * L1

    def cubic(x):
        c3 = A / (2.0 * HALF**3) - K3 / (2.0 * HALF**2)
        return c3 * x**3 - K3 * L1 / (2.0 * HALF**2) * x * x

    x = [0.4 * k / 1000 for k in range(-1000, 1001)]
    difference = max(abs(exact(v) - cubic(v)) for v in x)
    relative = difference / max(abs(exact(v)) for v in x)
    assert found['C3'].figures['vertical over 0.4'] == pytest.approx(relative, rel=1e-9)
    assert found['C3'].text == 'not reproduced' and relative > 0.035


def test_c4_both_loads(found):
    kg = 20000.0 * 0.6 / 9.80665
    expected = [0.05, 0.1 * 3.0 * 0.5 / math.sqrt(9.25), 0.05 * kg, 0.1 * L1 * kg]
    assert list(found['C4'].figures.values()) == pytest.approx(expected, rel=1e-12)
    assert found['C4'].text == 'reproduced'


def test_c5_rates(found):
    rates = [79380.0 * d**4 / (8 * n * D**3) * 1e3 for d, D, n in ((10, 60, 23), (8, 35, 42))]
    assert list(found['C5'].figures.values()) == pytest.approx(rates, rel=1e-12)
    assert [round(rate) for rate in rates] == [19973, 22570]
    assert found['C5'].text == 'reproduced'


def test_c6_radians(found):
    assert list(found['C6'].figures.values()) == pytest.approx([20.0, 10.0 / math.pi], rel=1e-12)
    assert found['C6'].text == 'not reproduced'


def test_a_report_waits_little_for_the_claims():
    began = time.process_time()
    verdicts(STATIC)
    assert time.process_time() - began < 0.05


def test_c13_vertical_sweeps_differ_and_horizontal_ones_do_not(found):
    figures = found['C13'].figures
    assert found['C13'].text == 'not reproduced'
    # the onset lags by less than 1 % of 3.3 Hz each way where no jump is
    assert all(abs(v) < 0.07 for name, v in figures.items() if name.startswith('horizontal'))
    low, high = (v for name, v in figures.items() if name.startswith('vertical'))
    assert 0.1 < low < high


def test_c14_linear_onset_is_that_of_a_linear_oscillator(found):
    figures = found['C14'].figures
    # T = 1 at sqrt(2) times sqrt(k3/m), whatever the damping
    resonance = math.sqrt(2000.0 / 50.0) / (2.0 * math.pi)
    assert figures['leaf springs alone, Hz'] == pytest.approx(math.sqrt(2.0) * resonance, rel=0.01)
    assert found['C14'].text == 'not reproduced'
    assert figures['QZS forward, 0.5 m/s², Hz'] < figures['leaf springs alone, Hz']
    assert figures['QZS forward, 4 m/s², Hz'] > figures['leaf springs alone, Hz']


def test_c7_the_transient_dies_as_the_damping_says(found):
    figures = found['C7'].figures
    assert found['C7'].text == 'not reproduced'
    assert all(value < 0 for name, value in figures.items() if name.startswith('largest'))
    # both multipliers are complex there, so each exponent is half of -2 zeta
    for dof in ('vertical', 'horizontal'):
        assert figures[f'exponent over -zeta, {dof}, Ω = 6.28'] == pytest.approx(1.0, abs=0.01)
        assert figures[f'spread for zeta < 0.05, {dof}, Ω = 6.28'] > 0.1
        assert figures[f'spread for zeta < 0.05, {dof}, 6.28 rad/s'] < 1e-4


def test_c8_chaos_is_vertical_and_needs_light_damping(found):
    figures = found['C8'].figures
    assert found['C8'].text == 'not reproduced'
    assert figures['largest exponent for L20 < 0.2, vertical, zeta = 0.0158'] > 0.01
    assert figures['largest exponent for L20 < 0.2, vertical, zeta = 0.07'] < 0
    for side in '<>':
        name = f'largest exponent for L20 {side} 0.2, horizontal, zeta = 0.0158'
        assert figures[name] == pytest.approx(-0.0158, abs=2e-4)


def test_c9_time_integration_has_settled_when_it_is_said_to(found):
    figures, omega = found['C9'].figures, 6.28 / 20.0
    assert found['C9'].text == 'reproduced'
    settled = int(figures['horizontal, 6.28 rad/s: settled after'])

    def motion(t, y):
        x = y[0]
        near, far = (math.hypot(HALF - s * x, L1) for s in (1, -1))
        pull = A * ((1 - near) * (HALF - x) / near - (1 - far) * (HALF + x) / far)
        force = pull + x * (1 - L1 / math.hypot(x, L1))
        return y[1], 0.6 * omega**2 * math.cos(omega * t) - 0.14 * y[1] - force

    times = 2 * math.pi / omega * np.array([settled - 3, settled, settled + 1])
    seen = solve_ivp(motion, (0, times[-1]), (0, 0), 'DOP853', times, rtol=1e-11, atol=1e-12).y[0]
    # the tool asks for what is left of the transient to be below 1e-8, and looks back a few periods
    assert abs(seen[2] - seen[1]) < 1e-7
    assert abs(seen[1] - seen[0]) < 1e-6


def test_c10_fold_and_transmissibility_of_29_are_roots(found):
    figures = found['C10'].figures
    for dof, c3 in (('vertical', 4.2), ('horizontal', 2 / 3)):
        for zeta in (0.0158, 0.07, 0.158):
            # MODEL: a cubic in W² at Ω = 3
            K, D, P = 0.75 * c3, 2 * zeta * 3.0, 0.6 * 9.0
            squares = np.roots([K**2, -2 * K * 9.0, 81.0 + D**2, -(P**2)])
            W = math.sqrt(min(s.real for s in squares if abs(s.imag) < 1e-9))
            cosine = (-9.0 * W + K * W**3) / P
            T = math.sqrt(W**2 + 0.36 + 1.2 * W * cosine) / 0.6
            assert figures[f'{dof}, zeta = {zeta:g}: T at Ω = 3 by (29)'] == pytest.approx(T)
            assert figures[f'{dof}, zeta = {zeta:g}: folds of (29)'] == 1.0


def test_c11_vertical_rotation_isolates_from_the_linear_onset(found):
    figures = found['C11'].figures
    inertia = 50.0 * 0.06**2 / 2.0
    for L20 in (0.1, 0.6, 1.0):
        # small angles: k3_hat L0_hat over k1 L20 L0, T = 1 at sqrt(2) times the resonance
        stiffness = 0.1 * (0.06 / L20) * 20000.0 * L20 * 0.06
        onset = math.sqrt(2.0 * stiffness / inertia)
        name = f'vertical_rotation, L20 = {L20:g} m: isolates from rad/s'
        assert figures[name] == pytest.approx(onset, rel=0.03)
    assert found['C11'].text == 'not reproduced'


def test_c12_rotations_are_within_and_translations_are_not(found):
    figures = found['C12'].figures
    assert found['C12'].text == 'not reproduced'
    assert figures['vertical_rotation: isolates from, over omega0'] == pytest.approx(
        math.sqrt(2 * K3 * 0.1), rel=0.01
    )
    assert 0.1 < figures['horizontal_rotation: isolates from, over omega0'] < 0.2
    # stiffness of large motion tends to 1 + A, vertically
    large = math.sqrt(2 * (1 + A))
    assert 0.6 * large < figures['vertical: isolates from, over omega0'] < large
