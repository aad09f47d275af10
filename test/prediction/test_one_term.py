"""The one-term prediction in hertz and metres against the dimensionless balance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from qzs_rig import scenario
from qzs_rig.excitation import QUANTITIES
from qzs_rig.mechanics.platform import Platform
from qzs_rig.prediction import one_term
from qzs_rig.prediction.scale import MARGIN, Scale
from qzs_rig.theory.single_term import folds, onset_omega, single_term

SCALE = Scale('vertical', 20.0, 0.6, amplitude=0.04, falloff=0, low_hz=0.5, high_hz=9.0)
LAW = {'c1': 0.15, 'c3': 4.2, 'zeta': 0.05}


def balance(scale, omega, c1=0.15, c3=4.2, zeta=0.05):
    return single_term(c1, c3, zeta, scale.amplitude * omega**-scale.falloff, omega)


@pytest.mark.parametrize('quantity', QUANTITIES)
def test_the_named_quantity_is_held(quantity):
    """Its amplitude, found again from Ĥ at any frequency, is the one that was given."""
    given = {'excitation.quantity': quantity, 'excitation.amplitude.vertical': 0.3}
    spec = scenario.of(given)
    scale = Scale.of(spec, Platform.from_spec(spec), 'vertical')
    f = np.array([0.5, 3.0, 20.0])
    base = scale.length * scale.amplitude * (f / scale.hertz) ** -scale.falloff
    derived = base * (2 * np.pi * f) ** QUANTITIES.index(quantity)
    np.testing.assert_allclose(derived, 0.3, rtol=1e-14)
    assert (scale.low_hz, scale.high_hz) == (1.0 / MARGIN, 4.0 * MARGIN)


def test_a_dwell_is_seen_an_octave_around():
    spec = scenario.of({'excitation.kind': 'sine', 'excitation.frequency': 3.0})
    scale = Scale.of(spec, Platform.from_spec(spec), 'horizontal')
    assert (scale.low_hz * MARGIN, scale.high_hz / MARGIN) == pytest.approx((1.5, 6.0))


@pytest.mark.parametrize('falloff', [0, 1, 2])
def test_branches_are_the_balance_in_hertz(falloff):
    scale = replace(SCALE, falloff=falloff)
    prediction = one_term.predict(scale, **LAW)
    assert {branch.name for branch in prediction.branches} == {'lower', 'middle', 'upper'}
    for branch in prediction.branches:
        assert (np.diff(branch.frequency_hz) > 0).all()
        answer = balance(scale, branch.frequency_hz / scale.hertz)
        for mine, theirs in (
            (branch.transmissibility, answer.T),
            (branch.phase_deg, answer.phase_deg),
            (branch.stroke / scale.length, answer.W),
        ):
            # omega went to hertz and back: near a fold the last bit moves a root by its root
            assert np.nanmin(np.abs(theirs - mine[:, None]), axis=1).max() < 1e-5
        assert branch.stable.all() == (branch.name != 'middle')


@pytest.mark.parametrize('falloff', [0, 1, 2])
@pytest.mark.parametrize(('c1', 'c3', 'zeta'), [(0.15, 4.2, 0.05), (1.0, -0.3, 0.03)])
def test_branches_are_continuous_and_end_at_folds(c1, c3, zeta, falloff):
    """Along a branch T never leaps; it ends at a fold or at the edge of the range."""
    scale = replace(SCALE, amplitude=0.04 if c3 > 0 else 0.1, falloff=falloff)
    scale = replace(scale, low_hz=1.8 if c3 < 0 else 0.5)
    prediction = one_term.predict(scale, c1, c3, zeta)
    edges = [scale.low_hz, scale.high_hz]
    places = folds(c1, c3, zeta, scale.amplitude, falloff) * scale.hertz
    assert len(prediction.branches) >= 3
    for branch in prediction.branches:
        assert np.abs(np.diff(np.log(branch.transmissibility))).max() < 0.16
        for end in branch.frequency_hz[[0, -1]]:
            assert np.min(np.abs(np.array([*edges, *places]) / end - 1)) < 2e-10


def test_folds_say_where_a_sweep_lands():
    prediction = one_term.predict(SCALE, **LAW)
    up, down = prediction.folds
    expected = folds(0.15, 4.2, 0.05, SCALE.amplitude) * SCALE.hertz
    # the last point is 1e-10 before the fold
    assert (up.frequency_hz, down.frequency_hz) == pytest.approx(tuple(expected), rel=2e-10)
    assert (up.kind, up.leaves, up.lands) == ('jump_up', 'lower', 'upper')
    assert (down.kind, down.leaves, down.lands) == ('jump_down', 'upper', 'lower')
    for fold in (up, down):
        answer = balance(SCALE, np.array([fold.frequency_hz / SCALE.hertz]))
        for value in fold.transmissibility:
            # next to the fold the two that meet part like the root of 1e-10
            assert np.nanmin(np.abs(answer.T / value - 1)) < 1e-4
    assert up.stroke[1] > up.stroke[0] and down.stroke[1] < down.stroke[0]


def test_a_fold_beyond_the_range_is_none():
    both = one_term.predict(SCALE, **LAW).folds
    between = replace(SCALE, high_hz=sum(fold.frequency_hz for fold in both) / 2)
    (up,) = one_term.predict(between, **LAW).folds
    assert up == both[0]


def test_no_fold_is_one_branch_with_its_onset():
    calm = one_term.predict(replace(SCALE, amplitude=1e-4), **LAW)
    (only,) = calm.branches
    assert (only.name, calm.folds) == ('only', ())
    assert calm.onset_hz == (onset_omega(0.15, 4.2, 0.05, 1e-4) * SCALE.hertz,)
