"""Bifurcation diagrams: chaos, cycles and transients told apart; sweeps that remember."""

from __future__ import annotations

import numpy as np
import pytest
from motion_laws import double_well

from qzs_rig import scenario
from qzs_rig.errors import InputError
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import PAPER_DESIGN
from qzs_rig.theory.motion.batch import Batch, batch_along
from qzs_rig.theory.motion.chaos import carried, from_rest
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.theory.single_term import folds


def test_an_undecayed_transient_is_not_called_chaos():
    """Erratum E16: Figure 13 with 6.28 put in as Omega still scatters at light damping."""
    own = Oscillator(RESTORING['closed_form'], 'vertical', PAPER_DESIGN, 0.07, 0.6)
    zeta = np.array([0.0158, 0.03, 0.05, 0.07, 0.1, 0.158])
    found = from_rest(Batch.of(own, 6.28, zeta=zeta))
    assert found.kind.tolist() == ['transient'] * 3 + ['periodic'] * 3
    # far from resonance the disturbance turns: both exponents are -zeta
    assert found.exponent[:3] == pytest.approx(-zeta[:3], abs=1e-3)
    assert np.isnan(found.exponent[3:]).all()
    # what is left after 100 periods of one time unit each
    assert np.ptp(found.seen.w[0]) > 0.1
    # twelve times as long a run is periodic
    longer = from_rest(Batch.of(own, 6.28, zeta=zeta), periods=3000)
    assert (longer.kind == 'periodic').all()


def test_figure_13_with_the_platforms_own_omega_has_no_transient_left():
    own = Oscillator(RESTORING['closed_form'], 'vertical', PAPER_DESIGN, 0.07, 0.6)
    found = from_rest(Batch.of(own, 0.314, zeta=[0.0158, 0.03, 0.1]))
    assert (found.kind == 'periodic').all()
    assert (found.seen.period == 1).all()


@pytest.mark.parametrize(
    ('push', 'kind'), [(0.2, 'periodic'), (0.37, 'periodic'), (0.5, 'chaotic')]
)
def test_chaos_is_called_chaos(push, kind):
    found = from_rest(Batch.of(double_well(push), 1.2, w=1.0), steps=48)
    assert found.kind[0] == kind
    assert found.count(kind) == 1


def test_a_lost_run_is_called_lost():
    own = Oscillator(RESTORING['corrected'], 'horizontal_rotation', PAPER_DESIGN, 0.02, 0.9)
    runs = Batch.of(own, [1.0, 1.1], w=0.9, velocity=1.0)
    assert from_rest(runs, periods=20, keep=10).count('lost') == 2
    assert carried(runs, periods=20, keep=10).count('lost') == 2


def test_a_sweep_that_remembers_jumps_at_the_folds():
    zeta, push = 0.05, 0.05
    own = Oscillator(RESTORING['symmetric'], 'vertical', PAPER_DESIGN, zeta, push, falloff=2)
    low, high = folds(0.0, 4.2, zeta, push, 2)
    omega = np.linspace(0.8 * low, 1.15 * high, 40)
    up = carried(Batch.of(own, omega), periods=400, keep=1).seen
    down = carried(Batch.of(own, omega[::-1]), periods=400, keep=1).seen
    size_up, size_down = np.abs(up.fundamental), np.abs(down.fundamental)[::-1]
    apart = omega[size_up > 1.2 * size_down]
    # one term of the balance places the folds of a cubic law to a few per cent here
    assert apart[0] == pytest.approx(low, rel=0.06)
    assert apart[-1] == pytest.approx(high, rel=0.06)
    assert up.runs.w[1:] == pytest.approx(up.end[:-1, 0], abs=0.0)


def spec(**words):
    return scenario.of({f'platform.{name}': value for name, value in words.items()})


def test_ratios_vary_alone():
    own = Oscillator.of(spec(), 'vertical', 0.6)
    values = np.array([0.1, 0.2])
    for name in ('zeta', 'amplitude', 'omega', 'load'):
        runs = batch_along(spec(), own, 0.5, name, values)
        assert getattr(runs, name).tolist() == values.tolist()
        assert (runs.design == runs.design[:, :1]).all()


@pytest.mark.parametrize('dof', ['vertical', 'vertical_rotation'])
def test_the_slant_length_holds_the_base_in_si(dof):
    own = Oscillator.of(spec(), dof, 0.3)
    runs = batch_along(spec(), own, 0.5, 'L20', np.array([0.3, 0.6, 1.2]))
    # L1/L20 stays, L0 stays in m
    assert runs.design[2] == pytest.approx(PAPER_DESIGN.L1)
    assert runs.design[3] == pytest.approx([0.2, 0.1, 0.05])
    if dof == 'vertical':
        assert runs.amplitude == pytest.approx([0.6, 0.3, 0.15])
        assert runs.omega == pytest.approx(0.5)
    else:
        assert runs.amplitude == pytest.approx(0.3)
        # stiffness k1 L20 L0 over the same inertia
        assert runs.omega == pytest.approx(0.5 * np.sqrt([2.0, 1.0, 0.5]))


def test_a_word_of_the_platform_changes_what_it_changes():
    own = Oscillator.of(spec(), 'vertical', 0.3)
    runs = batch_along(spec(), own, 0.5, 'platform.m', np.array([50.0, 200.0]))
    assert runs.omega == pytest.approx([0.5, 1.0])
    assert runs.zeta == pytest.approx([own.zeta, own.zeta / 2.0])
    held = spec().override({'platform.zeta': 0.07})
    own = Oscillator.of(held, 'vertical', 0.3)
    runs = batch_along(held, own, 0.5, 'platform.m', np.array([50.0, 200.0]))
    assert runs.zeta == pytest.approx(0.07)


def test_an_unknown_parameter_is_refused():
    own = Oscillator.of(spec(), 'vertical', 0.3)
    with pytest.raises(InputError, match="unknown parameter 'mass'; vary one of zeta"):
        batch_along(spec(), own, 0.5, 'mass', np.array([1.0]))
