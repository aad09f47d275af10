"""The prediction in one harmonic in hertz and metres against the dimensionless balance."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from qzs_rig import scenario
from qzs_rig.mechanics.restoring.law import Design
from qzs_rig.mechanics.restoring.polynomials import SYMMETRIC
from qzs_rig.prediction.predict import MARGIN, by_single_term, range_hz
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.theory.single_term import folds, onset_omega, single_term
from qzs_rig.units import QUANTITIES

DESIGN = Design.of(A=1.25, k3=0.4, L1=math.sqrt(3.0) / 2.0, L0=0.1)
"""Hardening: c1 = 0.15, c3 = 4.2."""
SOFTENING = Design.of(A=0.0, k3=0.15, L1=math.sqrt(3.0) / 2.0, L0=0.1)
"""c1 = 1.15, c3 = -0.3."""
OWN = Oscillator(SYMMETRIC, 'vertical', DESIGN, zeta=0.05, amplitude=0.04, omega0=20.0, length=0.6)
LOW, HIGH = 0.5, 9.0


def balance(own, omega):
    return single_term(*own.cubic, own.zeta, own.base(omega), omega)


@pytest.mark.parametrize('quantity', QUANTITIES)
def test_the_named_quantity_is_held(quantity):
    """Its amplitude, found again from Ĥ at any frequency, is the one that was given."""
    given = {'excitation.quantity': quantity, 'excitation.amplitude.vertical': 0.3}
    own = Oscillator.driven(scenario.of(given), 'vertical')
    f = np.array([0.5, 3.0, 20.0])
    base = own.length * own.base(own.omega(f))
    derived = base * (2 * np.pi * f) ** QUANTITIES.index(quantity)
    np.testing.assert_allclose(derived, 0.3, rtol=1e-14)
    assert range_hz(scenario.of(given)) == (1.0 / MARGIN, 4.0 * MARGIN)


def test_a_dwell_is_seen_an_octave_around():
    spec = scenario.of({'excitation.kind': 'sine', 'excitation.frequency': 3.0})
    low, high = range_hz(spec)
    assert (low * MARGIN, high / MARGIN) == pytest.approx((1.5, 6.0))


@pytest.mark.parametrize('falloff', [0, 1, 2])
def test_branches_are_the_balance_in_hertz(falloff):
    own = replace(OWN, falloff=falloff)
    prediction = by_single_term(own, LOW, HIGH)
    assert {branch.name for branch in prediction.branches} == {'lower', 'middle', 'upper'}
    for branch in prediction.branches:
        assert (np.diff(branch.frequency_hz) > 0).all()
        answer = balance(own, branch.frequency_hz / own.hertz)
        for mine, theirs in (
            (branch.transmissibility, answer.T),
            (branch.phase_deg, answer.phase_deg),
            (branch.stroke / own.length, answer.W),
        ):
            # omega went to hertz and back: near a fold the last bit moves a root by its root
            assert np.nanmin(np.abs(theirs - mine[:, None]), axis=1).max() < 1e-5
        assert branch.stable.all() == (branch.name != 'middle')


@pytest.mark.parametrize('falloff', [0, 1, 2])
@pytest.mark.parametrize(
    ('design', 'zeta', 'amplitude', 'low'),
    [(DESIGN, 0.05, 0.04, LOW), (SOFTENING, 0.03, 0.1, 1.8)],
)
def test_branches_are_continuous_and_end_at_folds(design, zeta, amplitude, low, falloff):
    """Along a branch T never leaps; it ends at a fold or at the edge of the range."""
    own = replace(OWN, design=design, zeta=zeta, amplitude=amplitude, falloff=falloff)
    prediction = by_single_term(own, low, HIGH)
    edges = [low, HIGH]
    places = folds(*own.cubic, zeta, amplitude, falloff) * own.hertz
    assert len(prediction.branches) >= 3
    for branch in prediction.branches:
        assert np.abs(np.diff(np.log(branch.transmissibility))).max() < 0.16
        for end in branch.frequency_hz[[0, -1]]:
            assert np.min(np.abs(np.array([*edges, *places]) / end - 1)) < 2e-10


def test_folds_say_where_a_sweep_lands():
    prediction = by_single_term(OWN, LOW, HIGH)
    up, down = prediction.folds
    expected = folds(*OWN.cubic, OWN.zeta, OWN.amplitude) * OWN.hertz
    # the last point is 1e-10 before the fold
    assert (up.frequency_hz, down.frequency_hz) == pytest.approx(tuple(expected), rel=2e-10)
    assert (up.kind, up.leaves, up.lands) == ('jump_up', 'lower', 'upper')
    assert (down.kind, down.leaves, down.lands) == ('jump_down', 'upper', 'lower')
    for fold in (up, down):
        answer = balance(OWN, np.array([fold.frequency_hz / OWN.hertz]))
        for value in fold.transmissibility:
            # next to the fold the two that meet part like the root of 1e-10
            assert np.nanmin(np.abs(answer.T / value - 1)) < 1e-4
    assert up.stroke[1] > up.stroke[0] and down.stroke[1] < down.stroke[0]


def test_a_fold_beyond_the_range_is_none():
    both = by_single_term(OWN, LOW, HIGH).folds
    between = sum(fold.frequency_hz for fold in both) / 2
    (up,) = by_single_term(OWN, LOW, between).folds
    assert up == both[0]


def test_no_fold_is_one_branch_with_its_onset():
    calm = by_single_term(replace(OWN, amplitude=1e-4), LOW, HIGH)
    (only,) = calm.branches
    assert (only.name, calm.folds) == ('only', ())
    assert calm.onset_hz == (onset_omega(*OWN.cubic, OWN.zeta, 1e-4) * OWN.hertz,)
