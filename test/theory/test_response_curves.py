"""Continuation over other parameters, curves of folds, backbones."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipk
from theory_motions import DUFFING, cubic, integrated, state

from qzs_rig.errors import InputError
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import PAPER_DESIGN
from qzs_rig.theory.balance.backbone import backbone, phase_resonance
from qzs_rig.theory.balance.frequency_response import frequency_response
from qzs_rig.theory.balance.harmonic_balance import value_of, with_value
from qzs_rig.theory.balance.variation import jump_map, varied_response
from qzs_rig.theory.oscillator import Oscillator

TAYLOR = Oscillator(RESTORING['taylor'], 'vertical', PAPER_DESIGN, 0.07, 0.3)


@pytest.mark.parametrize(
    ('parameter', 'low', 'high'),
    [('amplitude', 0.05, 1.0), ('zeta', 0.02, 0.5), ('A', 1.0, 1.3), ('k3', 0.02, 0.4),
     ('L1', 0.8, 0.9), ('L0', 0.05, 0.2)],
)  # fmt: skip
def test_motions_along_a_parameter_repeat(parameter, low, high):
    found = varied_response(TAYLOR, 0.6, parameter, low, high)
    assert found.branches
    for branch in found.branches:
        ends = branch.value.min() / low, branch.value.max() / high
        assert 1.0 in (pytest.approx(ends[0]), pytest.approx(ends[1]))
        for k in range(0, len(branch.value), max(1, len(branch.value) // 3)):
            at = with_value(TAYLOR, parameter, float(branch.value[k]))
            start = state(branch.coefficients[k], 0.6)
            end, flow = integrated(at, 0.6, start)
            np.testing.assert_allclose(end, start, atol=1e-6)
            assert (np.abs(np.linalg.eigvals(flow)).max() < 1.0) == branch.stable[k]


def test_folds_over_amplitude_are_those_over_frequency():
    fold = max(frequency_response(DUFFING, 0.8, 1.6, isolas=False).folds, key=lambda e: e.omega)
    found = varied_response(DUFFING, fold.omega, 'amplitude', 0.02, 0.5)
    values = [event.value for event in found.events if event.kind == 'fold']
    # a fold's frequency and its amplitude are found to 1e-10 of each other's slope
    assert min(abs(value / DUFFING.amplitude - 1) for value in values) < 1e-8


def test_the_jump_map_passes_the_folds():
    curves = jump_map(DUFFING, 'amplitude', (0.005, 0.4), 0.8, 2.0)
    assert len(curves) == 1
    value, omega = curves[0].value, curves[0].omega
    # below its cusp nothing jumps
    assert value.min() > 0.005
    for k in (5, len(value) // 2, len(value) - 5):
        at = with_value(DUFFING, 'amplitude', float(value[k]))
        folds = frequency_response(at, 0.8, 2.0, isolas=False).folds
        near = min(folds, key=lambda e, w=omega[k]: abs(e.omega - w))
        assert near.omega == pytest.approx(omega[k], abs=1e-8)
        assert pytest.approx(curves[0].T[k], rel=1e-6) == near.T


def test_backbone_of_the_cubic_oscillator_in_closed_form():
    """x'' + x + x³ = 0 from rest at X: ω = π sqrt(1 + X²) / (2 K(m)), m = X²/(2 (1 + X²))."""
    own = Oscillator(cubic(1.0, 1.0), 'vertical', PAPER_DESIGN, 0.02, 0.1)
    (curve,) = backbone(own, 0.5, 4.0)
    X = curve.coefficients[:, 0] + curve.coefficients[:, 1::2].sum(axis=1)
    expected = np.pi * np.sqrt(1 + X**2) / (2 * ellipk(X**2 / (2 * (1 + X**2))))
    np.testing.assert_allclose(curve.omega, expected, rtol=1e-9)
    np.testing.assert_allclose(curve.damping_ratio, 0.02 / curve.omega)


def test_phase_resonance_is_a_forced_motion():
    own = Oscillator(cubic(1.0, 1.0), 'vertical', PAPER_DESIGN, 0.02, 0.1)
    (free,) = backbone(own, 0.5, 4.0)
    curve = phase_resonance(own, free)
    for k in range(10, len(curve.omega), 30):
        at = with_value(own, 'amplitude', float(curve.drive_hat[k]))
        x = curve.coefficients[k]
        end, _ = integrated(at, curve.omega[k], state(x, curve.omega[k]))
        np.testing.assert_allclose(end, state(x, curve.omega[k]), atol=1e-7)
        assert abs(x[1]) < 1e-12
    # light damping: resonance is near the backbone, to the square of the damping ratio
    W = np.interp(curve.omega, free.omega, free.amplitude)
    inside = (curve.omega > 1.1) & (curve.omega < 3.5)
    np.testing.assert_allclose(curve.amplitude[inside], W[inside], rtol=5e-3)


def test_a_linear_law_resonates_at_one_frequency():
    own = Oscillator(cubic(1.0, 0.0), 'vertical', PAPER_DESIGN, 0.02, 0.1)
    (curve,) = backbone(own, 0.5, 2.0)
    np.testing.assert_allclose(curve.omega, 1.0, atol=1e-9)
    damped = phase_resonance(own, curve)
    np.testing.assert_allclose(damped.drive_hat, 0.04 * damped.amplitude, rtol=1e-6)


def test_quasi_zero_stiffness_starts_at_zero():
    own = Oscillator(RESTORING['symmetric'], 'vertical', PAPER_DESIGN, 0.02, 0.1)
    (curve,) = backbone(own, 0.02, 2.0)
    # w'' + 4.2 w³ = 0: frequency is proportional to amplitude
    ratio = curve.omega / curve.amplitude
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-9)


@pytest.mark.parametrize('call', [varied_response, jump_map])
def test_refusals(call):
    ask = {
        varied_response: lambda name, low, high: varied_response(TAYLOR, 0.6, name, low, high),
        jump_map: lambda name, low, high: jump_map(TAYLOR, name, (low, high), 0.1, 1.0),
    }[call]
    with pytest.raises(InputError, match="unknown parameter 'mass'"):
        ask('mass', 0.1, 0.2)
    with pytest.raises(InputError, match='give a range'):
        ask('zeta', 0.2, 0.1)


def test_refusals_of_values():
    with pytest.raises(InputError, match="unknown parameter 'mass'"):
        value_of(TAYLOR, 1.0, 'mass')
    with pytest.raises(InputError, match=r'L1 = 1\.2 must be below 1'):
        with_value(TAYLOR, 'L1', 1.2)
