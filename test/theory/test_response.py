"""Branches and events against published folds, time integration and their own definitions."""

from __future__ import annotations

import numpy as np
import pytest
from theory_motions import DUFFING, cubic, integrated, state

from qzs_rig.errors import InputError
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import PAPER_DESIGN
from qzs_rig.theory.balance.continuation import Ending, Stop
from qzs_rig.theory.balance.frequency_response import frequency_response, least_branch
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.theory.single_term import folds
from qzs_rig.units import DOFS, TRANSLATIONS


def omegas(response, kind='fold'):
    return [event.omega for event in response.events if event.kind == kind]


def vertical(law, zeta, amplitude):
    return Oscillator(RESTORING[law], 'vertical', PAPER_DESIGN, zeta, amplitude)


@pytest.fixture(scope='module')
def taylor():
    return frequency_response(vertical('taylor', 0.07, 0.6), 0.02, 3.0)


@pytest.fixture(scope='module')
def closed_form():
    return frequency_response(vertical('closed_form', 0.02, 0.6), 0.25, 1.6)


def test_duffing_folds_where_nlvib_has_them():
    found = frequency_response(DUFFING, 0.5, 1.6)
    assert len(found.branches) == 1
    # the reference is printed to ten digits, computed with seven harmonics
    assert sorted(omegas(found)) == pytest.approx([1.1157002518, 1.2696019555], abs=5e-8)


def test_taylor_folds_lie_on_an_isolated_branch(taylor):
    isola = taylor.branches[next(e.branch for e in taylor.events if e.omega < 1.0)]
    assert isola.ends == (Ending(Stop.CLOSED),) * 2
    assert sorted(omegas(taylor))[:2] == pytest.approx([0.2071890982, 0.4724070372], abs=1e-8)


def test_closed_form_folds(closed_form):
    main = [event.omega for event in closed_form.folds if event.branch == 0]
    assert main == pytest.approx([0.3176651784, 0.2964333635], abs=1e-8)


def test_closed_form_has_a_second_branch_that_motion_stays_on(closed_form):
    """It comes from low frequency and has three folds of its own."""
    own, branch = closed_form.oscillator, closed_form.branches[1]
    assert len([event for event in closed_form.folds if event.branch == 1]) == 3
    # near a fold kicks die out slowly: points whose multipliers are a pair of equal size
    size = np.abs(branch.multipliers)
    equal = branch.stable & (size[:, 0] < 1.001 * size[:, 1]) & (size[:, 1] < 1.001 * size[:, 0])
    places = np.flatnonzero(equal)[::8]
    assert len(places) > 2
    for k in places:
        start = state(branch.coefficients[k], branch.omega[k])
        # a kick of 1e-4 dies out as exp(-zeta t)
        periods = int(np.ceil(branch.omega[k] * np.log(1e4) / (2 * np.pi * own.zeta)))
        end, _ = integrated(own, branch.omega[k], start + np.array([1e-4, 0.0]), periods)
        np.testing.assert_allclose(end, start, atol=1e-6)


def test_as_many_harmonics_as_it_takes(closed_form):
    peak = int(np.argmax(closed_form.branches[0].T))
    assert 1.40 < closed_form.branches[0].omega[peak] < 1.44
    # the restoring force saturates: a motion of 20 L20 has a kink of width a/20
    assert closed_form.branches[0].harmonics[peak] > 15
    # a tail of 1e-8 of twenty L20, times its own squared frequency, over a drive of 1.2
    assert closed_form.branches[0].defect < 1e-2
    few = frequency_response(
        vertical('closed_form', 0.02, 0.6), 1.2, 1.6, harmonics=25, isolas=False
    )
    assert few.branches[0].defect > 0.05
    assert few.harmonics == 25
    assert few.branches[0].T.max() == pytest.approx(closed_form.branches[0].T.max(), rel=1e-2)


@pytest.mark.parametrize('law', RESTORING)
@pytest.mark.parametrize('dof', DOFS)
def test_time_integration_stays_on_stable_branches(law, dof):
    amplitude = 0.3 if dof in TRANSLATIONS else 0.0873
    own = Oscillator(RESTORING[law], dof, PAPER_DESIGN, 0.05, amplitude)
    found = frequency_response(own, 0.08, 2.5, isolas=False)
    assert found.branches
    for branch in found.branches:
        stable = np.flatnonzero(branch.stable)
        for k in stable[:: max(1, len(stable) // 4)]:
            start = state(branch.coefficients[k], branch.omega[k])
            end, flow = integrated(own, branch.omega[k], start)
            # the bound; motions are of order one
            np.testing.assert_allclose(end, start, atol=1e-6)
            assert np.abs(np.linalg.eigvals(flow)).max() < 1.0


def test_multipliers_are_those_of_the_flow(taylor):
    own = taylor.oscillator
    for branch in taylor.branches:
        for k in range(0, len(branch.omega), 25):
            start = state(branch.coefficients[k], branch.omega[k])
            _, flow = integrated(own, branch.omega[k], start)
            expected = np.linalg.eigvals(flow)
            # fourth order Magnus, 48 steps a swing and more
            assert np.sum(branch.multipliers[k]) == pytest.approx(np.sum(expected), abs=1e-5)
            assert np.prod(branch.multipliers[k]) == pytest.approx(
                np.exp(-4 * np.pi * own.zeta / branch.omega[k]), rel=1e-9
            )


@pytest.mark.parametrize(
    ('own', 'kind', 'multiplier'),
    [
        (vertical('taylor', 0.07, 0.6), 'fold', 1.0),
        (vertical('symmetric', 0.07, 0.6), 'symmetry_breaking', 1.0),
        (
            Oscillator(RESTORING['closed_form'], 'horizontal', PAPER_DESIGN, 0.07, 0.6),
            'period_doubling',
            -1.0,
        ),
    ],
)
def test_events_sit_where_the_flow_says(own, kind, multiplier):
    found = frequency_response(own, 0.15, 2.0)
    events = [event for event in found.events if event.kind == kind]
    assert events
    for event in events:
        start = state(event.coefficients, event.omega)
        end, flow = integrated(own, event.omega, start)
        np.testing.assert_allclose(end, start, atol=1e-8)
        sign = np.linalg.det(flow - multiplier * np.eye(2))
        # zero to what DOP853 leaves of a flow that stretches tenfold
        assert abs(sign) < 1e-6
        assert event.uncertainty < 1e-9


def test_both_directions_draw_the_same_branch():
    down, up = (least_branch(DUFFING, 0.5, 2.0, direction) for direction in ('down', 'up'))
    assert omegas(down) == pytest.approx(omegas(up), abs=1e-10)
    for found in (down, up):
        (branch,) = found.branches
        assert sorted(branch.omega[[0, -1]]) == [0.5, 2.0]
        assert branch.ends == (Ending(Stop.RANGE),) * 2


@pytest.mark.parametrize('falloff', [0, 1, 2])
def test_the_peak_lies_where_the_curve_stands_still(falloff):
    own = Oscillator(cubic(1.0, 0.05), 'vertical', PAPER_DESIGN, 0.1, 0.2, falloff=falloff)
    omega, T = frequency_response(own, 0.2, 2.5, isolas=False).peak
    # the square of a thousandth of the frequency off the peak
    for beside in (omega * 0.999, omega * 1.001):
        near = frequency_response(own, beside, 2.5, isolas=False).branches[0].T
        ends = near[0], near[-1]
        assert max(ends) < T
        assert max(ends) == pytest.approx(T, rel=1e-4)


def test_a_peak_at_a_fold():
    found = frequency_response(DUFFING, 0.5, 2.0)
    fold = max(found.folds, key=lambda event: event.omega)
    # light damping: the curve stands still just before it folds
    assert found.peak[1] >= max(fold.T, found.branches[0].T[found.branches[0].stable].max())
    assert found.peak[0] == pytest.approx(fold.omega, rel=1e-2)


def test_no_motion_at_the_end_is_told():
    own = Oscillator(RESTORING['closed_form'], 'horizontal_rotation', PAPER_DESIGN, 0.05, 1.5)
    found = least_branch(own, 0.5, 2.0, 'down', 7)
    assert found.branches == ()
    assert found.reason == 'no steady motion was found'


def test_broken_symmetry_joins_the_symmetric_branch():
    found = frequency_response(vertical('symmetric', 0.07, 0.6), 0.02, 2.0)
    parting = sorted(omegas(found, 'symmetry_breaking'))
    broken = [branch for branch in found.branches if not branch.symmetric]
    assert len(parting) == 2
    assert len(broken) == 1
    assert broken[0].ends == (Ending(Stop.SYMMETRY),) * 2
    assert sorted(broken[0].omega[[0, -1]]) == pytest.approx(parting, abs=1e-12)
    whole = next(branch for branch in found.branches if branch.symmetric)
    between = (whole.omega > parting[0]) & (whole.omega < parting[1])
    assert not whole.stable[between].any()
    assert whole.stable[~between].all()


def test_linear_law_in_closed_form():
    own = Oscillator(cubic(1.0, 0.0), 'horizontal', PAPER_DESIGN, 0.05, 0.3)
    found = frequency_response(own, 0.1, 3.0)
    (branch,) = found.branches
    s = 1j * branch.omega
    ratio = (1 + 0.1 * s) / (1 + 0.1 * s + s**2)
    # linear: Newton leaves rounding only
    np.testing.assert_allclose(branch.T, np.abs(ratio), rtol=1e-9)
    np.testing.assert_allclose(branch.phase_deg, np.degrees(np.angle(ratio)), atol=1e-7)
    np.testing.assert_allclose(branch.amplitude, 0.3 * np.abs(ratio - 1), rtol=1e-9)
    assert branch.stable.all()
    assert found.onset_omega == pytest.approx([np.sqrt(2.0)], abs=1e-9)
    assert found.events == ()


def test_small_motion_folds_as_one_harmonic_says():
    """Weak nonlinearity: one harmonic is right to the square of the third one, c3 W²/32."""
    own = Oscillator(cubic(1.0, 1e-3), 'vertical', PAPER_DESIGN, 0.01, 0.2, falloff=2)
    found = frequency_response(own, 0.5, 2.0, isolas=False)
    expected = folds(1.0, 1e-3, 0.01, 0.2, falloff=2)
    W = max(event.amplitude for event in found.folds)
    assert sorted(omegas(found)) == pytest.approx(list(expected), rel=(1e-3 * W**2) ** 2)


@pytest.mark.parametrize('falloff', [0, 1, 2])
def test_held_quantity_of_the_base(falloff):
    own = Oscillator(cubic(1.0, 0.05), 'vertical', PAPER_DESIGN, 0.1, 0.2, falloff=falloff)
    (branch,) = frequency_response(own, 0.2, 2.5, isolas=False).branches
    k = len(branch.omega) // 3
    end, _ = integrated(own, branch.omega[k], state(branch.coefficients[k], branch.omega[k]))
    np.testing.assert_allclose(end, state(branch.coefficients[k], branch.omega[k]), atol=1e-7)
    w = branch.coefficients[k, 1] - 1j * branch.coefficients[k, 2]
    v = 0.2 * branch.omega[k] ** -falloff
    assert branch.T[k] == pytest.approx(abs(1 + w / v), rel=1e-12)


def test_a_branch_that_leaves_the_law_says_so():
    own = Oscillator(RESTORING['corrected'], 'horizontal_rotation', PAPER_DESIGN, 0.02, 0.9)
    found = frequency_response(own, 0.05, 1.0, isolas=False)
    assert found.reason is not None
    assert 'law corrected ends at |w| = 1' in found.reason
    assert found.branches


def test_same_input_same_bits():
    own = vertical('corrected', 0.05, 0.3)
    first, second = (frequency_response(own, 0.2, 2.0) for _ in range(2))
    assert all(
        np.array_equal(a.coefficients, b.coefficients)
        for a, b in zip(first.branches, second.branches, strict=True)
    )


def test_progress_reaches_the_end():
    told = []
    own = vertical('linear', 0.05, 0.3)
    frequency_response(own, 0.2, 2.0, progress=lambda share, text: told.append(share))
    assert told == sorted(told)
    assert told[-1] == 1.0


@pytest.mark.parametrize(('low', 'high'), [(0.0, 1.0), (2.0, 1.0), (1.0, np.inf), (-1.0, 1.0)])
def test_refuses_a_range_that_does_not_rise(low, high):
    with pytest.raises(InputError, match='give a range that rises'):
        frequency_response(vertical('linear', 0.05, 0.3), low, high)


def test_refuses_a_base_at_rest():
    with pytest.raises(InputError, match='needs a base that moves'):
        frequency_response(vertical('linear', 0.05, 0.0), 0.1, 1.0)
