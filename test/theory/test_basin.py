"""Basins and jump margins: symmetry, agreement with single runs, kicks that just do."""

from __future__ import annotations

import math

import numpy as np
import pytest
from motion_laws import double_well, ueda

from qzs_rig.errors import InputError
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import PAPER_DESIGN
from qzs_rig.theory.motion.basin import LOST, UNSETTLED, basin, jump_margin
from qzs_rig.theory.motion.batch import Batch
from qzs_rig.theory.motion.stroboscope import history, strobe
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.theory.single_term import single_term

ZETA, PUSH, OMEGA = 0.05, 0.05, 0.75


def bistable():
    """A hardening law between its folds, where two cycles live; constant acceleration."""
    return Oscillator(RESTORING['symmetric'], 'vertical', PAPER_DESIGN, ZETA, PUSH, falloff=2)


def test_two_branches_have_two_basins():
    found = basin(bistable(), OMEGA, np.linspace(-1, 1, 24), np.linspace(-0.6, 0.6, 24))
    assert len(found.attractors) == 2
    assert sum(each.share for each in found.attractors) == pytest.approx(1.0)
    assert found.attractors[0].share >= found.attractors[1].share
    theory = single_term(0.0, 4.2, ZETA, PUSH * OMEGA**-2, OMEGA)
    sizes = sorted(each.high for each in found.attractors)
    # one term, against all of them
    assert sizes == pytest.approx(sorted(theory.W[0][theory.stable[0]]), rel=0.05)
    # every start leads where a run of its own leads
    row, column = 3, 17
    own = Batch.of(bistable(), OMEGA, w=found.w[column], velocity=found.velocity[row])
    alone = strobe(own, steps=found.steps, periods=1000, keep=0)
    T = found.attractors[found.which[row, column]].T
    assert abs(alone.transmissibility[0]) == pytest.approx(T, rel=1e-4)


def test_an_odd_law_has_basins_that_mirror_half_a_period_later():
    own = double_well(0.28)
    w, velocity = np.linspace(-1.5, 1.5, 21), np.linspace(-1, 1, 21)
    here = basin(own, 1.2, w, velocity)
    there = basin(own, 1.2, -w, -velocity, phase=math.pi)
    assert [each.period for each in here.attractors] == [2, 2]
    assert (here.which >= 0).all()
    assert (there.which >= 0).all()

    def extremes(found, low, high):
        own = np.array([[getattr(each, low), getattr(each, high)] for each in found.attractors])
        return own[found.which]

    mirrored = np.abs(extremes(here, 'low', 'high') + extremes(there, 'high', 'low')) < 1e-5
    # the border is fractal: where a start lies on it, rounding decides
    assert np.mean(mirrored.all(axis=-1)) > 0.99


def test_starts_that_are_lost_and_starts_that_never_settle():
    own = Oscillator(RESTORING['corrected'], 'horizontal_rotation', PAPER_DESIGN, 0.1, 0.05)
    found = basin(own, 0.5, [0.0, 0.9], [0.0, 1.0])
    assert found.which[1, 1] == LOST
    chaos = basin(ueda(), 1.0, [2.4, 2.5], [0.0], periods=100)
    assert (chaos.which == UNSETTLED).all()
    assert chaos.attractors == ()


def test_the_margin_is_where_a_kick_begins_to_do():
    margin = jump_margin(bistable(), OMEGA, largest_kick=1.0)
    assert margin.other is not None
    assert margin.other.T > 2.0 * margin.now.T
    assert 0.0 < margin.kick < 1.0
    # by hand: follow the motion to that phase, kick, and wait
    steps, turn = 80, margin.kick_phase_deg / 360.0
    rest = Batch.of(bistable(), OMEGA, w=margin.now.w, velocity=margin.now.velocity)
    run = history(rest, 1, steps)
    k = round(turn * steps)
    kicks = margin.kick * np.array([0.9, -0.9, 1.0, -1.0])
    kicked = Batch.of(bistable(), OMEGA, w=run.w[k], velocity=run.velocity[k] + kicks)
    after = strobe(kicked, steps=steps, periods=1000, keep=0, phase=2 * math.pi * turn)
    jumped = np.abs(after.transmissibility) > 2.0 * margin.now.T
    assert not jumped[:2].any()
    assert jumped[2:].any()


def test_the_level_that_makes_it_jump_is_where_the_lower_branch_ends():
    margin = jump_margin(bistable(), OMEGA, largest_kick=1.0, largest_rise=8.0)
    levels = PUSH * np.linspace(1.0, 8.0, 400)
    lower = np.array([single_term(0.0, 4.2, ZETA, a * OMEGA**-2, OMEGA).stable[0] for a in levels])
    end = levels[np.argmax(lower.sum(axis=1) < 2)] / PUSH
    # a sudden rise overshoots: it jumps at most where the slow one does
    assert 1.0 < margin.rise <= 1.05 * end


def test_a_motion_without_rival_has_no_margin():
    own = Oscillator(RESTORING['linear'], 'vertical', PAPER_DESIGN, 0.1, 0.3)
    margin = jump_margin(own, 0.5, largest_kick=1.0)
    assert math.isnan(margin.kick)
    assert math.isnan(margin.rise)
    assert margin.other is None


def test_a_margin_of_chaos_is_refused():
    with pytest.raises(InputError, match='does not settle within 60 periods'):
        jump_margin(ueda(), 1.0, largest_kick=1.0, periods=60)


@pytest.mark.parametrize(
    'bounds', [{'largest_kick': 0.0}, {'largest_kick': 1.0, 'largest_rise': 1}]
)
def test_bounds_of_nothing_are_refused(bounds):
    with pytest.raises(InputError, match='needs a largest kick above 0 and a largest rise above 1'):
        jump_margin(bistable(), OMEGA, **bounds)
