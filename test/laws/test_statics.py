"""Statics: QZS conditions, soft range, load, deviation, and where an unbalanced payload rests."""

from __future__ import annotations

import numpy as np
import pytest

from qzs_rig.errors import InputError
from qzs_rig.mechanics import statics
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import PAPER_DESIGN, Design
from qzs_rig.units import DOFS, GRAVITY

EPS = np.finfo(float).eps
WEIGHTED = ('closed_form', 'corrected', 'taylor', 'printed', 'geometric')
X = np.array([-0.3, -0.1, 0.0, 0.1, 0.4])

every_law = pytest.mark.parametrize('law', RESTORING.values(), ids=RESTORING)
every_dof = pytest.mark.parametrize('dof', DOFS)


def test_the_triples_of_the_paper_fulfil_16():
    designs = statics.triples(PAPER_DESIGN)
    pairs = [(design.A, design.k3) for design in designs]
    assert pairs == [pytest.approx(pair, rel=1e-14) for pair in ((1.1, 0.1), (1.5, 0.5), (2, 1))]
    for design in designs:
        found = statics.conditions(design)
        assert abs(found.vertical) < 32 * EPS  # A/a of order 4 cancels
        assert found.least_suspension == pytest.approx(1.0, rel=1e-14)  # a/(1 - a), erratum E3


def test_condition_17_as_printed_is_another():
    # erratum E3: 1/((1 - L1)² - 1) is negative, no bound at all
    L1 = PAPER_DESIGN.L1
    assert 1 / ((1 - L1) ** 2 - 1) < 0 < statics.conditions(PAPER_DESIGN).least_suspension


@pytest.mark.parametrize('a', [0.2, 0.5, 0.8])
def test_17_is_where_16_asks_for_no_leaf_spring(a):
    assert statics.suspension_for(0.0, a) == pytest.approx(a / (1 - a), rel=4 * EPS)


def test_conditions_are_the_stiffness_at_the_working_point():
    design = Design.of(0.8, 0.3, 0.7, 0.15)
    found = statics.conditions(design)
    vertical, _, yaw, pitch = RESTORING['corrected'].stiffness(design, np.zeros(4))
    assert found[:3] == pytest.approx((vertical, yaw, pitch), abs=16 * EPS)


@every_law
@every_dof
def test_a_curve_carries_the_static_load(law, dof):
    curve = statics.curve(law, PAPER_DESIGN, dof, X)
    carried = PAPER_DESIGN.b if law.name in WEIGHTED and dof == 'vertical' else 0.0
    assert curve.static_load == carried
    assert curve.force[2] == pytest.approx(carried, abs=8 * EPS)
    motion = np.zeros((len(X), 4))
    motion[:, DOFS.index(dof)] = X
    net = law.force(PAPER_DESIGN, motion)[:, DOFS.index(dof)]
    assert np.array_equal(curve.force, net + carried)


@pytest.mark.parametrize('x', [1.0, -1.0, 1.5])
def test_a_point_outside_the_domain_is_refused(x):
    with pytest.raises(InputError, match=r'outside the domain of corrected; give \|x\| < 1'):
        statics.curve(RESTORING['corrected'], PAPER_DESIGN, DOFS[3], np.array([0.0, x]))


@every_law
@every_dof
@pytest.mark.parametrize('tolerance', [0.02, 0.6])
def test_the_soft_range_ends_where_the_stiffness_reaches_the_tolerance(law, dof, tolerance):
    number = DOFS.index(dof)

    def stiffness(x):
        motion = np.zeros((len(x), 4))
        motion[:, number] = x
        return np.abs(law.stiffness(PAPER_DESIGN, motion)[:, number])

    soft = statics.soft_range(law, PAPER_DESIGN, dof, tolerance)
    if soft is None:
        assert stiffness(np.zeros(1))[0] > tolerance
        return
    low, high = soft
    assert low < 0 < high
    assert stiffness(np.linspace(low, high, 1001)[1:-1]).max() <= tolerance
    for end in soft:
        if abs(end) < min(statics.FAR, law.domain[number]) * (1 - 1e-12):
            # bisected to the last bit, times a slope of order 10
            assert stiffness(np.array([end]))[0] == pytest.approx(tolerance, abs=1e-12)


def test_the_paper_is_right_that_closer_A_to_1_is_softer_for_longer():
    widths = [
        np.diff(statics.soft_range(RESTORING['closed_form'], design, 'vertical', 0.02))[0]
        for design in statics.triples(PAPER_DESIGN)
    ]
    assert widths == sorted(widths, reverse=True)


def test_condition_16_leaves_a_slightly_negative_stiffness_below_the_working_point():
    """The even term -b/(2a²) x² tilts (8): K = 2 c2 x + 3 c3 x² is least -c2²/(3 c3)."""
    _, c2, c3 = RESTORING['taylor'].taylor(PAPER_DESIGN)[0]
    lowest = statics.lowest_stiffness(RESTORING['taylor'], PAPER_DESIGN, 'vertical', 0.1)
    # on a grid of 1e-4, half of which costs 3 c3 (5e-5)² = 3e-8
    assert lowest == pytest.approx(-(c2**2) / (3 * c3), abs=3.2e-8)
    closed = statics.lowest_stiffness(RESTORING['closed_form'], PAPER_DESIGN, 'vertical', 0.1)
    assert closed == pytest.approx(lowest, rel=0.01)  # the law goes on beyond third order


def test_load_capacity_is_odd_rises_and_saturates_at_k3_a():
    x0 = np.linspace(-50, 50, 1001)
    load = statics.load_capacity(PAPER_DESIGN, x0)
    # linspace is symmetric to the rounding of 50
    assert np.allclose(load, -load[::-1], rtol=0, atol=64 * EPS)
    assert np.all(np.diff(load) > 0)
    end = statics.saturated_load(PAPER_DESIGN)
    assert end == pytest.approx(0.05, rel=1e-15)
    # a²/(2 x0²) is left at 50
    assert load[-1] == pytest.approx(end, rel=1e-4)
    assert load[-1] < end
    # k1 L20 = 12 kN: the paper's m >= 50 kg has 61.2 kg above it
    assert end * 12e3 / GRAVITY == pytest.approx(61.18, abs=5e-3)


def test_equation_24_is_less_than_the_load_that_equation_8_carries():
    """k3 a < k3 L1 = b wherever the suspension is steeper than 45 degrees."""
    assert statics.saturated_load(PAPER_DESIGN) < PAPER_DESIGN.b


@every_dof
def test_a_law_does_not_deviate_from_itself(dof):
    law = RESTORING['closed_form']
    assert statics.deviation(law, law, PAPER_DESIGN, dof, 0.4) == (0.4, 0.0, 0.0)


@every_dof
def test_deviation_is_within_the_limit_as_far_as_it_says_and_not_beyond(dof):
    pair = RESTORING['taylor'], RESTORING['closed_form']
    reach = statics.reach_within(*pair, PAPER_DESIGN, dof, 0.035)
    assert statics.deviation(*pair, PAPER_DESIGN, dof, reach).relative <= 0.035
    if reach < 2.0:
        assert statics.deviation(*pair, PAPER_DESIGN, dof, reach + 0.01).relative > 0.035


@every_law
@pytest.mark.parametrize('load', [-0.05, -1e-4, 1e-4, 0.05])
def test_equilibrium_is_the_first_crossing_towards_the_load(law, load):
    x = statics.equilibrium(law, PAPER_DESIGN, load)
    along = np.zeros((1001, 4))
    along[:, 0] = np.linspace(0, x, 1001)
    force = law.force(PAPER_DESIGN, along)[:, 0]
    assert force[-1] == pytest.approx(load, abs=8 * EPS)
    assert np.all(force[:-1] * np.sign(load) < abs(load))


@every_law
def test_a_balanced_payload_rests_at_the_working_point(law):
    assert statics.equilibrium(law, PAPER_DESIGN, 0.0) == 0.0


def test_a_load_that_no_spring_holds_is_refused():
    falling = Design.of(0.0, 0.5, 0.6, 0.1)  # without suspension the cubic term is negative
    with pytest.raises(InputError, match='law symmetric holds nowhere; bring'):
        statics.equilibrium(RESTORING['symmetric'], falling, 5.0)
