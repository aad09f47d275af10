"""Theory in hertz and metres against the dimensionless balance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from qzs_rig.compare.theory_overlay import HELD, theory_curve, theory_curves
from qzs_rig.errors import InputError
from qzs_rig.theory.single_term import single_term


@pytest.mark.parametrize('held', HELD)
def test_amplitude_is_held(case, held):
    """The named quantity has the same amplitude at every frequency."""
    held_case = replace(case, held=held, amplitude=0.3)
    f = np.array([0.5, 3.0, 20.0])
    derived = held_case.amplitude_at(f) * (2 * np.pi * f) ** HELD[held]
    np.testing.assert_allclose(derived, 0.3, rtol=1e-14)


@pytest.mark.parametrize(('held', 'amplitude'), [*zip(HELD, (0.025, 0.25, 5.0), strict=True)])
def test_curve_is_the_balance_in_hertz(case, held, amplitude):
    held_case = replace(case, held=held, amplitude=amplitude)
    curve = theory_curve(held_case, 0.5, 9.0)
    omega = 2 * np.pi * curve.frequency_hz / case.omega0
    amplitude_hat = held_case.amplitude_at(curve.frequency_hz) / case.length
    answer = single_term(case.c1, case.c3, case.zeta, amplitude_hat, omega)
    np.testing.assert_array_equal(np.sort(curve.magnitude), np.sort(answer.T))
    assert np.count_nonzero(curve.stable) == np.count_nonzero(answer.stable)
    assert (curve.frequency_hz[0], curve.frequency_hz[-1]) == (0.5, 9.0)


@pytest.mark.parametrize('held', HELD)
@pytest.mark.parametrize(('c1', 'c3', 'zeta'), [(0.15, 4.2, 0.05), (1.0, -0.3, 0.03)])
def test_columns_are_continuous(case, held, c1, c3, zeta):
    """Along a column T never leaps: between drawn points only by what a steep curve climbs."""
    amplitude = (0.04 if c3 > 0 else 0.1) * case.length * case.omega0 ** HELD[held]
    bent = replace(case, c1=c1, c3=c3, zeta=zeta, held=held, amplitude=amplitude)
    curve = theory_curve(bent, 1.8 if c3 < 0 else 0.5, 9.0)
    assert bent.folds_hz().size >= 1
    assert np.isfinite(curve.magnitude).all(axis=1).any()
    assert not np.isfinite(curve.magnitude).all(axis=1).all()
    assert np.nanmax(np.abs(np.diff(np.log(curve.magnitude), axis=0))) < 0.08
    # A column begins and ends only at a fold or at the edge of the range.
    ends = np.flatnonzero(np.diff(np.isfinite(curve.magnitude), axis=0).any(axis=1))
    for at in curve.frequency_hz[ends]:
        assert np.min(np.abs(bent.folds_hz() / at - 1)) < 1e-9


def test_branches_meet_at_the_folds(case):
    curve = theory_curve(case, 0.5, 9.0)
    rows = np.flatnonzero(np.isfinite(curve.magnitude).all(axis=1))
    first, last = curve.magnitude[rows[0]], curve.magnitude[rows[-1]]
    # 1e-10 inside a fold the two roots are its square root, 1e-5, apart.
    assert first[0] == pytest.approx(first[1], rel=1e-3)
    assert last[2] == pytest.approx(last[1], rel=1e-3)


def test_no_fold_is_one_branch(case):
    curve = theory_curve(replace(case, amplitude=1e-4), 0.5, 9.0)
    assert np.isfinite(curve.magnitude[:, 0]).all()
    assert np.isnan(curve.magnitude[:, 1:]).all()


def test_every_case_has_its_curve(case):
    curves = theory_curves([case, replace(case, dof='horizontal')], 1.0, 2.0)
    assert [curve.dof for curve in curves] == ['vertical', 'horizontal']


@pytest.mark.parametrize(
    ('change', 'message'),
    [
        ({'held': 'jerk'}, "held is 'jerk'; known: displacement, velocity, acceleration"),
        ({'omega0': 0.0}, 'omega0 is 0.0'),
        ({'length': -1.0}, 'length is -1.0'),
    ],
)
def test_refuses(case, change, message):
    with pytest.raises(InputError, match=message):
        replace(case, **change)


def test_refuses_an_empty_range(case):
    with pytest.raises(InputError, match=r'theory range is 2.0 to 1.0 Hz'):
        theory_curve(case, 2.0, 1.0)
