"""The platform in SI: Table 1, its dimensionless words, its defaults, what it warns of."""

from __future__ import annotations

import math

import numpy as np
import pytest

from qzs_rig import scenario
from qzs_rig.errors import InputError
from qzs_rig.mechanics.platform import Platform
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import PAPER_DESIGN
from qzs_rig.units import DOFS, displacement_unit

ALL, NONE = (True,) * 4, (False,) * 4


def platform(**given) -> Platform:
    return Platform.from_spec(
        scenario.of({f'platform.{k.replace("__", ".")}': v for k, v in given.items()})
    )


def test_table_1():
    rig = platform()
    assert rig.omega0[:2] == pytest.approx((20.0, 20.0), rel=1e-15)  # sqrt(20000 / 50)
    # 44.3 / (2 sqrt(20000 * 50)); the ratio of rotations is carried through two square roots
    assert rig.zeta == pytest.approx((0.02215,) * 4, rel=1e-14)
    # SI values over L20 = 0.6 round once each
    assert tuple(rig.design) == pytest.approx(tuple(PAPER_DESIGN), rel=1e-15)


def test_the_linear_mode_of_the_paper_is_at_1_hz():
    rig = platform(law='linear')
    c1, _ = rig.law.cubic(rig.design)[0]
    # erratum E10; four digits are quoted
    assert rig.omega0[0] * math.sqrt(c1) / (2 * math.pi) == pytest.approx(1.0066, abs=5e-5)


def test_a_disc_unless_told():
    m, L0 = 50.0, 0.06
    assert platform().mass == pytest.approx((m, m, m * L0**2 / 2, m * L0**2 / 4), rel=1e-15)
    told = platform(I_vm=0.3, I_hm=0.2)
    assert told.mass == (m, m, 0.3, 0.2)
    assert told.zeta == pytest.approx((0.02215,) * 4, rel=1e-14)


def test_damping_given_by_degree_of_freedom():
    rig = platform(**{f'C__{dof}': 1.0 + n for n, dof in enumerate(DOFS)})
    assert rig.damping == (1.0, 2.0, 3.0, 4.0)
    assert platform(zeta=0.07).zeta == pytest.approx((0.07,) * 4, rel=1e-14)


def test_si_and_dimensionless_words_build_the_same_platform():
    si = platform(k1=8e3, k2=1.2e4, k3=2.4e3, L20=0.5, L1=0.4, L0=0.05)
    hat = platform(k1=8e3, A=1.5, k3_hat=0.3, L20=0.5, L1_hat=0.8, L0_hat=0.1)
    assert tuple(si.design) == pytest.approx(tuple(hat.design), rel=1e-15)
    for name in ('mass', 'damping', 'length', 'stiffness'):
        assert getattr(si, name) == pytest.approx(getattr(hat, name), rel=1e-15)


def test_stiffness_scales_a_torque_by_the_plates_radius():
    rig = platform(k1=1e4, L20=0.8, L0=0.1)
    assert rig.stiffness == pytest.approx((1e4, 1e4, 1e4 * 0.8 * 0.1, 1e4 * 0.8 * 0.1), rel=1e-15)
    assert rig.length == (-0.8, 0.8, 1.0, 1.0)


@pytest.mark.parametrize('given', [{'L1': 0.6}, {'L1': 0.7}, {'L1_hat': 1.0}, {'L20': 0.5}])
def test_springs_that_would_not_incline_are_refused(given):
    with pytest.raises(InputError, match=r'platform\.L1 / L20 = .* must be below 1.*shorten L1'):
        platform(**given)


@pytest.mark.parametrize('law', [law for law in RESTORING if law not in ('linear', 'geometric')])
def test_a_plate_that_tips_is_announced_when_it_is_driven(law):
    text = ' '.join(platform(law=law).cautions(ALL))
    assert 'horizontal_rotation has negative stiffness (-0.01)' in text
    assert platform(law=law).cautions(NONE) == []
    assert 'negative' not in ' '.join(platform(law=law, L0_hat=0.08).cautions(ALL))


def test_a_vertical_beyond_condition_16_is_announced():
    vertical = tuple(dof == 'vertical' for dof in DOFS)
    assert 'vertical has negative stiffness' in platform(A=1.3).cautions(vertical)[0]
    assert platform().cautions(vertical) == []


@pytest.mark.parametrize('law', ['closed_form', 'taylor', 'printed'])
def test_the_false_well_of_the_printed_horizontal_law_is_announced(law):
    sideways = tuple(dof == 'horizontal' for dof in DOFS)
    assert 'false well' in platform(law=law).cautions(sideways)[0]
    assert platform().cautions(sideways) == []


def test_the_linear_law_needs_no_caution():
    assert platform(law='linear').cautions(ALL) == []


def test_units_of_motion():
    assert [displacement_unit(dof) for dof in DOFS] == ['m', 'm', 'rad', 'rad']


@pytest.mark.parametrize('x', [0.05, 0.3])
def test_vertical_is_up_where_the_paper_is_down(x):
    """The force on +z displacement is minus the paper's force at -x."""
    rig = platform(law='closed_form')

    def force(w):
        column = np.full(4, w / rig.length[0])
        return rig.stiffness[0] * rig.length[0] * rig.law.force(rig.design, column)[0]

    k1, L20, (A, k3, L1, _, a, b) = 2e4, 0.6, PAPER_DESIGN

    def paper(x):  # Eq (8), downward positive, less the weight
        length = math.hypot(x, a)
        return k1 * L20 * (x + A * x * (1 - 1 / length) + k3 * a / length * (x + L1) - b)

    for w in (x, -x):
        # order 1e4 N out of terms of that size
        assert force(w) == pytest.approx(-paper(-w / L20), abs=1e-10)
    # up, the leaf springs carry less of the weight: the pull back is weaker than from below
    assert abs(force(x)) != pytest.approx(abs(force(-x)), rel=1e-3)


@pytest.mark.parametrize('law', RESTORING)
@pytest.mark.parametrize('trim', [-20.0, -0.5, 0.5, 30.0])
def test_a_trimmed_payload_rests_where_the_springs_hold_its_weight(law, trim):
    rig = platform(law=law, payload_trim=trim)
    w, rate = np.array([rig.rest[0], 0.0, 0.0, 0.0]), 2e4 * 0.6
    force = rate * rig.law.force(rig.design, w)[0]
    assert force == pytest.approx(trim * 9.80665, abs=1e-10)  # terms of 1e4 N
    # heavier hangs lower, and the plate comes back to it
    assert math.copysign(1, w[0]) == math.copysign(1, trim)
    assert rig.law.stiffness(rig.design, w)[0] > 0
    assert rig.mass[:2] == (50.0 + trim, 50.0 + trim)


@pytest.mark.parametrize('law', RESTORING)
def test_the_cubic_of_a_trimmed_platform_is_taken_where_it_rests(law):
    rig = platform(law=law, payload_trim=10.0)
    step = 1e-3
    motion = np.zeros((3, 4))
    motion[:, 0] = rig.rest[0] + step * np.array([-1.0, 0.0, 1.0])
    before, at, after = rig.law.stiffness(rig.design, motion)[:, 0]
    c1, c3 = rig.cubic[0]
    assert c1 == pytest.approx(at, abs=1e-12)
    # second difference: its error is step² / 12 times a fourth derivative of order 1e3
    assert c3 == pytest.approx((before - 2 * at + after) / step**2 / 6, abs=1e-3)
    assert rig.cubic[1:] == rig.law.cubic(rig.design)[1:]


def test_a_trim_is_announced_with_its_rest_position():
    rig = platform(payload_trim=30.0)
    assert f'{-600 * rig.rest[0]:+.4g} mm' in rig.cautions(NONE)[0]


def test_taking_off_more_than_there_is_is_refused():
    with pytest.raises(InputError, match=r'payload_trim = -50 takes more .* above 0'):
        platform(payload_trim=-50.0)


def test_a_weight_that_nothing_holds_is_refused():
    with pytest.raises(InputError, match=r'payload_trim .* law linear holds nowhere; bring'):
        platform(law='linear', k3=0.0, payload_trim=1.0)
