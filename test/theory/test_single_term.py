"""The one-term balance against its own equation, the linear closed form, the paper's check values
and the integrated motion."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from qzs_rig.errors import InputError
from qzs_rig.theory.single_term import folds, onset_omega, peak, single_term

PAPER_VERTICAL = {'c1': 0.0, 'c3': 4.2, 'zeta': 0.07, 'amplitude_hat': 1 / 12}
LAWS = [
    (0.0, 4.2, 0.07, 0.05),
    (0.2, 4.2, 0.03, 0.01),
    (1.0, 0.5, 0.05, 0.2),
    (1.0, -0.3, 0.03, 0.1),
    (1.0, 1e-13, 0.1, 0.3),
    (1.0, 0.0, 0.02, 0.1),
    (-0.1, 2.0, 0.1, 0.05),
]
OMEGA = np.geomspace(0.02, 20, 400)


def linear(omega, zeta):
    """Absolute transmissibility of the linear isolator, complex (n,): any vibration textbook."""
    return (1 + 2j * zeta * omega) / (1 - omega**2 + 2j * zeta * omega)


def integrated(law, omega, start, cycles=200):
    """Complex u/v at the drive frequency over the last 20 cycles, from relative phasor `start`."""
    c1, c3, zeta, amplitude = law

    def rate(t, y):
        drive = amplitude * omega**2 * np.cos(omega * t)
        return y[1], drive - 2 * zeta * y[1] - c1 * y[0] - c3 * y[0] ** 3

    period = 2 * np.pi / omega
    t = (cycles - 20 + np.arange(20 * 64) / 64) * period
    y0 = [start.real, -omega * start.imag]
    w = solve_ivp(rate, (0, t[-1]), y0, 'DOP853', t, rtol=1e-9, atol=1e-12).y[0]
    return 1 + 2 * np.mean(w * np.exp(-1j * omega * t)) / amplitude


def relative_phasor(answer, branch, amplitude):
    ratio = answer.T[0, branch] * np.exp(1j * np.radians(answer.phase_deg[0, branch]))
    return amplitude * (ratio - 1)


def test_paper_vertical_check_values():
    answer = single_term(**PAPER_VERTICAL, omega=[0.2, 0.5])
    # MODEL section 5 prints six decimals.
    np.testing.assert_allclose(answer.T[0], [1.840268, np.nan, np.nan], atol=1e-6)
    np.testing.assert_allclose(answer.T[1], [0.314178, 2.739556, 3.830048], atol=1e-6)
    assert answer.stable.tolist() == [[True, False, False], [True, False, True]]


@pytest.mark.parametrize('zeta', [0.01, 0.07, 0.5, 2.0])
@pytest.mark.parametrize(('c3', 'amplitude'), [(0.0, 0.1), (1e-300, 0.1), (4.2, 0.0), (0.0, 0.0)])
def test_linear_limit(zeta, c3, amplitude):
    answer = single_term(1.0, c3, zeta, amplitude, OMEGA)
    expected = linear(OMEGA, zeta)
    # Twelve digits: no cancellation in the formula, only the rounding of a few products.
    np.testing.assert_allclose(answer.T[:, 0], np.abs(expected), rtol=1e-12)
    np.testing.assert_allclose(answer.phase_deg[:, 0], np.degrees(np.angle(expected)), atol=1e-10)
    assert np.all(np.isnan(answer.T[:, 1:]))
    assert np.all(answer.phase_deg[:, 0] < 0)


@pytest.mark.parametrize(('c1', 'c3', 'zeta', 'amplitude'), LAWS)
def test_every_root_fulfils_the_balance(c1, c3, zeta, amplitude):
    W = single_term(c1, c3, zeta, amplitude, OMEGA).W
    x = OMEGA[:, None] ** 2
    left = ((c1 - x + 0.75 * c3 * W**2) ** 2 + 4 * zeta**2 * x) * W**2
    size = ((abs(c1) + x + 0.75 * abs(c3) * W**2) ** 2 + 4 * zeta**2 * x) * W**2
    # Rounding of the largest term, with a few operations in between.
    assert np.nanmax(np.abs(left - (amplitude * x) ** 2) / size) < 1e-14
    finite = np.isfinite(W)
    assert np.all(finite[:, 0])
    assert np.all(np.diff(W, axis=1)[finite[:, 1:]] >= 0)


@pytest.mark.parametrize(('c1', 'c3', 'zeta', 'amplitude'), LAWS)
def test_transmissibility_is_the_papers_form(c1, c3, zeta, amplitude):
    answer = single_term(c1, c3, zeta, amplitude, OMEGA)
    W, x = answer.W, OMEGA[:, None] ** 2
    cosine = ((c1 - x) * W + 0.75 * c3 * W**3) / (amplitude * x)
    sine = -2 * zeta * OMEGA[:, None] * W / (amplitude * x)
    T = np.sqrt(W**2 + amplitude**2 + 2 * W * amplitude * cosine) / amplitude
    phase = np.degrees(np.arctan2(W * sine, amplitude + W * cosine))
    # The paper's form cancels where T is small: absolute, at the size of W/Ĥ.
    np.testing.assert_allclose(answer.T, T, atol=1e-7 * np.nanmax(W / amplitude))
    turn = (answer.phase_deg - phase + 180) % 360 - 180
    assert np.nanmax(np.abs(turn)[answer.T > 1e-2]) < 1e-4


@pytest.mark.parametrize(
    ('law', 'omega', 'tolerance'),
    [
        # The neglected third harmonic, c3 W²/(36 Ω²) of W, stays below 1 % in the fundamental.
        ((1.0, 0.5, 0.05, 0.1), 0.9, 0.01),
        ((1.0, 0.2, 0.03, 0.1), 1.12, 0.01),
        ((1.0, 0.5, 0.03, 0.05), 1.1, 0.01),
        ((1.0, -0.1, 0.02, 0.1), 0.93, 0.01),
        ((0.0, 4.2, 0.07, 0.07), 0.6, 0.01),
        # The paper's point moves 3.4 times its base: there one term is good to 3 % only.
        ((0.0, 4.2, 0.07, 1 / 12), 0.5, 0.03),
    ],
)
def test_stable_branches_are_the_integrated_motion(law, omega, tolerance):
    amplitude = law[3]
    answer = single_term(*law, omega)
    branches = np.flatnonzero(answer.stable[0])
    assert branches.size >= 1
    for branch in branches:
        start = relative_phasor(answer, branch, amplitude)
        ratio = integrated(law, omega, start)
        assert abs(ratio - 1 - start / amplitude) < tolerance * abs(start) / amplitude


def test_middle_branch_is_left():
    c1, c3, zeta, amplitude, omega = 1.0, 0.2, 0.03, 0.1, 1.12
    answer = single_term(c1, c3, zeta, amplitude, omega)
    assert answer.stable.tolist() == [[True, False, True]]
    start = relative_phasor(answer, 1, amplitude)
    ratio = integrated((c1, c3, zeta, amplitude), omega, start)
    distance = np.abs(np.abs(ratio) - answer.T[0])
    assert np.argmin(distance) != 1


def test_tipping_plate_is_not_stable():
    """c1 < 0: the balance has a small centred branch, the plate slides into a well instead."""
    c1, c3, zeta, amplitude, omega = -0.1, 2.0, 0.1, 0.02, 1.0
    answer = single_term(c1, c3, zeta, amplitude, omega)
    assert not answer.stable[0, 0]

    def rate(t, y):
        drive = amplitude * omega**2 * np.cos(omega * t)
        return y[1], drive - 2 * zeta * y[1] - c1 * y[0] - c3 * y[0] ** 3

    w = solve_ivp(rate, (0, 400), [1e-6, 0], max_step=0.1).y[0]
    well = np.sqrt(-c1 / c3)
    assert abs(np.mean(w[-600:])) > 0.5 * well


@pytest.mark.parametrize('falloff', [0, 1, 2])
@pytest.mark.parametrize(('c1', 'c3', 'zeta', 'amplitude'), LAWS)
def test_branches_appear_at_the_folds(c1, c3, zeta, amplitude, falloff):
    edges = folds(c1, c3, zeta, amplitude, falloff)
    assert np.all(np.diff(edges) > 0)

    def count(omega):
        answer = single_term(c1, c3, zeta, amplitude * omega**-falloff, omega)
        return int(np.sum(np.isfinite(answer.W)))

    for edge in edges:
        # The contract is 1e-10; the side with three branches must begin within it.
        assert sorted([count(edge * (1 - 1e-10)), count(edge * (1 + 1e-10))]) == [1, 3]
    middles = np.sqrt(edges[:-1] * edges[1:])
    ends = [edges[0] * 0.9, *middles, edges[-1] * 1.1] if edges.size else [0.5, 1.0, 2.0]
    counts = [count(omega) for omega in ends]
    assert all(a != b for a, b in pairwise(counts)) or not edges.size


@pytest.mark.parametrize('falloff', [0, 1, 2])
@pytest.mark.parametrize(('c1', 'c3', 'zeta', 'amplitude'), LAWS)
def test_onset_has_unit_transmissibility(c1, c3, zeta, amplitude, falloff):
    onset = onset_omega(c1, c3, zeta, amplitude, falloff)
    if onset is None:
        return
    above = onset * np.array([1, 1.001])
    answer = single_term(c1, c3, zeta, amplitude * above**-falloff, above)
    distance = np.where(answer.stable, np.abs(answer.T - 1), np.inf)
    assert distance[0].min() < 1e-9
    assert answer.T[1, np.argmin(distance[0])] < 1


def test_linear_onset_is_root_two():
    assert onset_omega(1.0, 0.0, 0.3, 0.1) == pytest.approx(np.sqrt(2), rel=1e-12)


@pytest.mark.parametrize('zeta', [0.001, 0.05, 0.4])
def test_linear_peak_is_the_closed_form(zeta):
    found = peak(1.0, 0.0, zeta, 0.1)
    r2 = (np.sqrt(1 + 8 * zeta**2) - 1) / (4 * zeta**2)
    # T is flat at its peak: its argument shows to the root of the rounding.
    assert found.omega == pytest.approx(np.sqrt(r2), rel=1e-6)
    np.testing.assert_allclose(found.T, abs(linear(np.sqrt(r2), zeta)), rtol=1e-12)


def test_purely_cubic_law_loses_its_jump_down():
    """MODEL section 5: no jump-down, so no peak, once Ĥ > 2ζ/sqrt(¾ c3)."""
    zeta, c3 = 0.02215, 4.2
    limit = 2 * zeta / np.sqrt(0.75 * c3)
    assert limit == pytest.approx(0.025, abs=1e-4)
    assert peak(0.0, c3, zeta, 1.001 * limit) is None
    assert len(folds(0.0, c3, zeta, 1.001 * limit)) == 1
    assert len(folds(0.0, c3, zeta, 0.999 * limit)) % 2 == 0
    assert peak(0.0, c3, zeta, 0.9 * limit).T > 1


def test_peak_bounds_every_stable_point():
    for c1, c3, zeta, amplitude in LAWS:
        found = peak(c1, c3, zeta, amplitude)
        if found is not None:
            answer = single_term(c1, c3, zeta, amplitude, np.linspace(0.5, 1.5, 999) * found.omega)
            assert np.max(answer.T[answer.stable]) <= found.T * (1 + 1e-9)


def test_overdriven_and_weak_laws_have_no_peak():
    assert peak(0.0, 0.0, 0.1, 0.1) is None
    assert peak(1.0, 0.0, 0.0, 0.1) is None


def test_undamped_resonance_has_no_branch():
    answer = single_term(1.0, 0.0, 0.0, 0.1, [0.5, 1.0, 2.0])
    assert np.isfinite(answer.T[:, 0]).tolist() == [True, False, True]
    assert answer.phase_deg[[0, 2], 0].tolist() == [0.0, 180.0]


@pytest.mark.parametrize(
    ('change', 'message'),
    [
        ({'zeta': -0.1}, r'zeta is -0.1; .* 0 or more'),
        ({'amplitude_hat': np.nan}, 'amplitude_hat is nan'),
        ({'omega': [0.1, 0.0]}, 'omega is 0.0; .* above 0'),
    ],
)
def test_refuses(change, message):
    with pytest.raises(InputError, match=message):
        single_term(**({**PAPER_VERTICAL, 'omega': [1.0]} | change))


def test_refuses_an_unknown_falloff():
    with pytest.raises(InputError, match=r'falloff is 3; give 0 \(displacement\)'):
        folds(**PAPER_VERTICAL, falloff=3)
