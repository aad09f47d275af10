"""The pieces of an identification against closed forms and second methods."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from qzs_rig import scenario
from qzs_rig.errors import InputError
from qzs_rig.identification.fit import LOST, DataSet, Fit, minimised
from qzs_rig.identification.jumps import Fold, fold_near, left_null
from qzs_rig.identification.point_response import (
    followed,
    iso_limit,
    nearest,
    ratios,
    sensitivity,
    swept_over_steady,
)
from qzs_rig.identification.points import read_csv
from qzs_rig.identification.unknowns import unknowns
from qzs_rig.theory.balance.frequency_response import frequency_response
from qzs_rig.theory.balance.harmonic_balance import HarmonicBalance, steady
from qzs_rig.theory.oscillator import Oscillator


def test_sensitivity_is_the_difference_of_two_responses(bench):
    wanted = unknowns(bench.spec, ('platform.zeta', 'platform.A', 'platform.k1'), ['vertical'])
    points = bench.points()
    here = nearest(Oscillator.driven(bench.spec, 'vertical'), points, 5)
    use = here.good
    slope = sensitivity(wanted, wanted.start, points, here)
    for k, scale in enumerate(wanted.scale):
        h = 1e-5 * scale * np.eye(3)[k]
        over, under = (
            followed(
                Oscillator.driven(wanted.applied(wanted.start + s * h), 'vertical'),
                points.frequency_hz,
                here.x,
            ).ratio
            for s in (1.0, -1.0)
        )  # fmt: skip
        expected = np.log(over / under) / (2e-5 * scale)
        # central differences of a Newton solution: 1e-12 / 1e-5 over the slope
        assert slope[use, k] == pytest.approx(expected[use], rel=1e-4, abs=1e-6)


def test_a_point_that_loses_its_branch_keeps_its_motion_and_counts_as_lost(bench):
    wanted = unknowns(bench.spec, ('platform.zeta', 'platform.A'), ['vertical'])
    points = bench.points()
    here = nearest(Oscillator.driven(bench.spec, 'vertical'), points, 5)
    counted = DataSet(
        points, np.where(here.good, '', 'on no branch'), np.ones(20, complex), (0.1, 0.1)
    )
    fit = Fit(wanted, (counted,), wanted.start, (here,))
    # damped eight times as much the upper branch ends earlier
    damped = fit.moved(wanted.start * [8.0, 1.0])
    lost = fit.good & ~damped.good
    assert lost.any() and damped.good.any()
    assert damped.penalised[lost[damped.counted]] == pytest.approx(LOST)
    gone = lost[:20]
    assert np.array_equal(damped.responses[0].x[gone], here.x[gone])
    # what is left leads back to the platform that was measured
    found = minimised(damped, np.ones(2, bool), 1e-9)
    assert found.values == pytest.approx(bench.truth[0, :2], rel=0.01)


def test_a_magnitude_implies_the_phase_of_a_damped_motion(bench):
    spec = bench.spec.override({'platform.zeta': 0.08, 'platform.payload_trim': 0.3})
    there, full = Oscillator.driven(spec, 'vertical'), bench.points()
    silent = replace(full, phase=np.full(len(full), np.nan))
    true = full.magnitude * np.exp(1j * full.phase)
    miss = np.min([np.abs(guess - true) for guess in ratios(there, silent)], axis=0)
    # the power that higher harmonics take is left out: up to a tenth near the jump
    assert np.max(miss / full.magnitude) < 0.1
    assert np.median(miss / full.magnitude) < 0.002


@pytest.mark.parametrize('quantity', ['displacement', 'velocity', 'acceleration'])
def test_the_lag_of_a_linear_platform_is_the_known_one(quantity):
    """w = D H - i Ω'/2 D H'' - i Ω' D' H' under a drive of slowly changing amplitude D."""
    falloff = ('displacement', 'velocity', 'acceleration').index(quantity)
    spec = scenario.of(
        {
            'platform.law': 'linear',
            'platform.k3_hat': 0.5,
            'platform.zeta': 0.1,
            'excitation.quantity': quantity,
            'excitation.amplitude.vertical': 0.01,
        }
    )
    there, rate = Oscillator.driven(spec, 'vertical'), 1e-5
    omega = np.linspace(0.3, 2.0, 9)
    x = np.zeros((9, 3))
    x[:, 1] = 0.01
    x = steady(there, omega, x).coefficients

    def H(w):
        return 1.0 / (0.5 - w**2 + 0.2j * w)

    def D(w):
        return w ** (2.0 - falloff)

    h = 1e-3
    H1, H2 = (
        (H(omega + h) - H(omega - h)) / (2 * h),
        (H(omega + h) - 2 * H(omega) + H(omega - h)) / h**2,
    )
    D1, V = (D(omega + h) - D(omega - h)) / (2 * h), omega ** -float(falloff)
    quadrature = -1j * (1 - 2 * falloff) * rate * V
    w = (D(omega) + quadrature) * H(omega) - 1j * rate * (0.5 * D(omega) * H2 + D1 * H1)
    w1 = D1 * H(omega) + D(omega) * H1
    acceleration = (1j * rate - omega**2) * w + 2j * omega * rate * w1
    swept = 1.0 + acceleration / -(D(omega) + quadrature)
    settled = 1.0 + omega**2 * D(omega) * H(omega) / D(omega)
    found = swept_over_steady(there, omega, np.full(9, rate), x)
    # both are first order in the rate: they differ by its square, 1e-10 times 1/ζ² squared
    assert found - 1.0 == pytest.approx(swept / settled - 1.0, abs=2e-7)
    assert np.max(np.abs(found - 1.0)) > 1e-5


def test_iso_limit():
    # 54 f²/Q² Hz a minute at f = 10 Hz, Q = 50
    assert iso_limit(10.0 / 50.0) == pytest.approx(54 * 0.2**2 / 60)


def test_a_fold_is_followed_and_its_slope_right(bench):
    there = Oscillator.driven(bench.spec, 'vertical')
    event = max(frequency_response(there, 0.2, 2.0, isolas=False).folds,
                key=lambda fold: fold.omega)  # fmt: skip
    fold = fold_near(there, Fold(event.omega * 1.001, event.coefficients[:19]))
    assert fold.omega == pytest.approx(event.omega, rel=1e-3)
    other = replace(there, zeta=there.zeta + 1e-6)
    moved = fold_near(other, fold).omega - fold.omega
    left, balance = left_null(there, fold), HarmonicBalance(there, 9)
    by_zeta = left @ (HarmonicBalance(other, 9).residual(fold.x, fold.omega)) / 1e-6
    h = 1e-6
    by_omega = left @ (balance.residual(fold.x, fold.omega + h) -
                       balance.residual(fold.x, fold.omega - h)) / (2 * h)  # fmt: skip
    assert moved / 1e-6 == pytest.approx(-by_zeta / by_omega, rel=1e-3)


def test_a_fold_that_is_not_there_is_not_found(bench):
    damped = Oscillator.driven(bench.spec.override({'platform.zeta': 0.9}), 'vertical')
    x = np.zeros(11)
    x[1] = 0.05
    assert fold_near(damped, Fold(0.6, x)) is None


HEADER = 'dof,direction,frequency_hz,transmissibility,phase_deg,std\n'


def test_csv_round_trip(tmp_path):
    path = tmp_path / 'curve.csv'
    path.write_text(HEADER + 'vertical,forward,1.5,2.0,-30,0.1\nhorizontal,,2.0,0.5,,\n')
    vertical, horizontal = read_csv(path)
    assert (vertical.dof, horizontal.dof) == ('vertical', 'horizontal')
    assert vertical.phase == pytest.approx(np.radians([-30.0]))
    assert vertical.weighted and not horizontal.weighted
    assert horizontal.direction.tolist() == ['none'] and not horizontal.phased.any()


@pytest.mark.parametrize(
    ('text', 'said'),
    [
        ('', 'the header lacks dof, frequency_hz, transmissibility'),
        ('dof,frequency_hz\n', 'the header lacks transmissibility'),
        ('dof,frequency_hz,transmissibility,colour\n', 'the header has colour'),
        (HEADER, 'no rows'),
        (HEADER + 'updown,none,1,1,,\n', "line 2: dof is 'updown'"),
        (HEADER + 'vertical,up,1,1,,\n', "line 2: direction is 'up'"),
        (HEADER + 'vertical,none,1,x,,\n', "transmissibility is 'x', not a number"),
        (HEADER + 'vertical,none,-1,1,,\n', 'frequency_hz is -1'),
        (HEADER + 'vertical,none,1,1,,0\n', 'std is 0'),
        (HEADER + 'vertical,none,1\n', "transmissibility is '', not a number"),
    ],
)
def test_csv_refusals(tmp_path, text, said):
    path = tmp_path / 'curve.csv'
    path.write_text(text)
    with pytest.raises(InputError, match=said):
        read_csv(path)


def test_a_csv_that_is_not_there(tmp_path):
    with pytest.raises(InputError, match='cannot be read as CSV'):
        read_csv(tmp_path / 'no.csv')
