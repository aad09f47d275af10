"""Restoring laws: one value from every evaluator, symmetry, Taylor terms, strain energy."""

from __future__ import annotations

import cmath
import math
import sys

import numpy as np
import pytest

from qzs_rig import scenario
from qzs_rig.mechanics.platform import Platform
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import MANY, PAPER_DESIGN, Design, compiled
from qzs_rig.units import DOFS

DESIGNS = {
    'paper': PAPER_DESIGN,
    'paper 1.5': Design.of(1.5, 0.5, math.sqrt(0.75), 0.1),
    'paper 2': Design.of(2.0, 1.0, math.sqrt(0.75), 0.1),
    'off condition (16)': Design.of(0.8, 0.3, 0.7, 0.15),
}
W = np.linspace(-0.95, 0.95, 381)
EPS = np.finfo(float).eps

every_law = pytest.mark.parametrize('law', RESTORING.values(), ids=RESTORING)
every_design = pytest.mark.parametrize('design', DESIGNS.values(), ids=DESIGNS)
every_dof = pytest.mark.parametrize('dof', range(4), ids=DOFS)


def formula(law, dof, sqrt=cmath.sqrt):
    return RESTORING[law].along(DOFS.index(dof), sqrt)


def taylor(function, design, order):
    """Taylor coefficient by Cauchy's integral: the trapezoid on a circle converges geometrically.

    Singularities lie at |w| >= 0.5 and the circle at 0.2, so 64 points leave 0.4^64 = 3e-26.
    """
    z = 0.2 * np.exp(2j * np.pi * np.arange(64) / 64)
    values = np.array([function(design, complex(w)) for w in z])
    return float(np.mean(values * z**-order).real)


def derivative(function, design, w):
    """Complex step: exact to rounding, nothing is subtracted."""
    return complex(function(design, complex(w, 1e-150))).imag / 1e-150


@every_law
@every_design
def test_array_and_scalar_evaluation_give_the_same_bits(law, design):
    array = law.force(design, np.repeat(W[:, None], 4, axis=1))
    scalar = [[law.along(n, math.sqrt)(design, w) for n in range(4)] for w in W.tolist()]
    assert np.array_equal(array, scalar)


@every_law
@every_dof
def test_compiled_evaluation_gives_the_same_bits(law, dof):
    fast, plain = compiled(law)[dof], law.along(dof, math.sqrt)
    for design in DESIGNS.values():
        got = [fast(law.numbers(design, dof), w) for w in W.tolist()]
        assert got == [plain(design, w) for w in W.tolist()]


@every_law
@every_design
def test_the_working_point_is_an_equilibrium(law, design):
    # terms of order 1 cancel there: a few roundings remain
    assert np.abs(law.force(design, np.zeros(4))).max() <= 8 * EPS


@every_law
@every_design
@every_dof
def test_taylor_coefficients_are_those_of_the_force(law, design, dof):
    function = law.along(dof, cmath.sqrt)
    for order, coefficient in enumerate(law.taylor(design)[dof], start=1):
        # values of order 0.2 divided by 0.2^3, summed over 64 points: some 1e3 roundings
        assert taylor(function, design, order) == pytest.approx(coefficient, abs=1e-12)


@every_law
@every_design
def test_cubic_coefficients_are_the_odd_taylor_terms(law, design):
    assert law.cubic(design) == tuple((c1, c3) for c1, _, c3 in law.taylor(design))


@every_design
def test_the_taylor_law_is_the_closed_form_to_third_order(design):
    """Their difference is of fourth order: halving w divides it by 16 or more."""
    for dof in range(4):
        exact, cubic = (RESTORING[law].along(dof, math.sqrt) for law in ('closed_form', 'taylor'))
        coarse, fine = (abs(exact(design, w) - cubic(design, w)) for w in (0.002, 0.001))
        # the yaw law is even flatter; its difference is down at the roundings
        assert coarse < 1e-14 or math.log2(coarse / fine) > 3.9, dof


@every_law
@every_design
@every_dof
def test_stiffness_is_the_slope_of_the_force(law, design, dof):
    function, stiffness = law.along(dof, cmath.sqrt), law.stiffness(design, np.tile(W, (4, 1)).T)
    slope = [derivative(function, design, w) for w in W.tolist()]
    # 1 / a^3 = 8 and, at 0.95, 1 / c = 3 magnify the roundings
    assert np.allclose(stiffness[:, dof], slope, rtol=64 * EPS, atol=128 * EPS)


@every_law
@every_dof
def test_a_law_is_finite_inside_its_domain_and_refused_beyond(law, dof):
    bound = law.domain[dof]
    inside = np.zeros(4)
    inside[dof] = min(math.nextafter(bound, 0.0), 1e3)
    assert np.isfinite(law.force(PAPER_DESIGN, inside)[dof])
    assert np.isfinite(law.stiffness(PAPER_DESIGN, inside)[dof])
    if bound < math.inf:
        with np.errstate(invalid='ignore'):
            assert np.isnan(law.force(PAPER_DESIGN, np.full(4, 1.001 * bound))[dof])


@every_law
@every_design
def test_si_and_nondimensional_forces_say_the_same(law, design):
    k1, L20, w = 8e3, 0.5, np.array([0.1, -0.07, 0.3, -0.2])
    words = {'law': law.name, 'k1': k1, 'L20': L20, 'A': design.A, 'k3_hat': design.k3}
    words |= {'L1_hat': design.L1, 'L0_hat': design.L0}
    rig = Platform.from_spec(scenario.of({f'platform.{k}': v for k, v in words.items()}))
    lever = design.L0 * L20
    scale = k1 * L20 * np.array([1.0, 1.0, lever, lever])
    si = np.array(rig.stiffness) * np.abs(rig.length) * law.force(rig.design, w)
    assert si / scale == pytest.approx(law.force(design, w), rel=8 * EPS, abs=8 * EPS)


@every_law
def test_many_points_give_the_same_bits_with_and_without_numba(law, monkeypatch):
    # two whole blocks and a part, in three dimensions and not contiguous
    w = np.random.default_rng(3).uniform(-0.9, 0.9, (4, 40_000, 2))[:, :, ::-1]
    w = np.swapaxes(np.concatenate([w, w, w], axis=-1), 0, 2)[..., ::-1]
    assert w.size >= MANY
    plain = np.stack([law.along(n)(PAPER_DESIGN, w[..., n]) for n in range(4)], axis=-1)
    assert law.force(PAPER_DESIGN, w).tobytes() == plain.tobytes()
    monkeypatch.setitem(sys.modules, 'numba', None)
    compiled.cache_clear()
    assert law.force(PAPER_DESIGN, w).tobytes() == plain.tobytes()
    compiled.cache_clear()


def test_complex_motion_stays_complex_however_many_the_points():
    w = np.full((MANY, 4), 0.1 + 1e-150j)
    assert RESTORING['corrected'].force(PAPER_DESIGN, w).dtype == np.complex128


def printed_coefficients():
    """d1…d8 below Eq (27) for the paper's choice of ratios."""
    (d3, d2, d1), (_, d4, d5), (d6, _, d7), (_, d8, _) = RESTORING['printed'].taylor(PAPER_DESIGN)
    return d1, d2, d3, d4, d5, d6, d7, d8


def test_the_coefficients_of_the_paper():
    """MODEL section 3."""
    root = math.sqrt(3)
    assert PAPER_DESIGN.b == pytest.approx(root / 20, abs=1e-12)  # 0.0866025
    expected = (4.2, -root / 10, 0.0, -1.2375, 2 / 3, 0.01, -0.01055, 0.01)
    assert printed_coefficients() == pytest.approx(expected, abs=1e-12)


def test_the_printed_laws_are_powers_of_w_with_these_coefficients():
    (d1, d2, d3, d4, d5, d6, d7, d8), w = printed_coefficients(), W
    expected = [
        d1 * w**3 + d2 * w**2 + d3 * w,
        d4 * w**2 + d5 * w**3,
        d6 * w + d7 * w**3,
        d8 * (-w + w**2 + w**3 / 2),
    ]
    got = RESTORING['printed'].force(PAPER_DESIGN, np.tile(w, (4, 1)).T)
    assert np.allclose(got.T, expected, rtol=0, atol=16 * EPS)


@every_design
def test_the_symmetric_law_is_the_odd_part_of_the_printed_one(design):
    w = np.tile(W, (4, 1)).T
    printed_law, symmetric = (RESTORING[name] for name in ('printed', 'symmetric'))
    odd = (printed_law.force(design, w) - printed_law.force(design, -w)) / 2
    assert np.allclose(symmetric.force(design, w), odd, rtol=0, atol=16 * EPS)


def test_the_printed_yaw_and_pitch_are_not_the_expansion():
    """Errata E5 and E6: the cubic terms of (22), (27) and (13), of (23) and (15) differ."""
    right, wrong = (RESTORING[law].taylor(PAPER_DESIGN) for law in ('taylor', 'printed'))
    A, k3, _, L0, _, _ = PAPER_DESIGN
    assert right[2][2] == pytest.approx(-(A / 2 + k3) * L0**3, rel=4 * EPS)
    assert wrong[2][2] == pytest.approx(-A / 2 * L0**3 - k3 * L0, rel=4 * EPS)
    # (23) halves A L0 - k3 where (15) halves k3 alone
    assert right[3][2] - wrong[3][2] == pytest.approx(A * L0 / 2, rel=8 * EPS)


@pytest.mark.parametrize('name', ['closed_form', 'corrected', 'taylor', 'printed', 'geometric'])
def test_a_weighted_law_carries_b_and_is_net_of_it(name):
    assert RESTORING[name].static_load(PAPER_DESIGN) == (PAPER_DESIGN.b, 0.0, 0.0, 0.0)


@pytest.mark.parametrize('name', ['symmetric', 'linear'])
def test_a_law_without_bias_carries_nothing(name):
    assert RESTORING[name].static_load(PAPER_DESIGN) == (0.0,) * 4


@every_law
@every_design
def test_axisymmetric_motions_pull_back_alike_on_both_sides(law, design):
    for dof in law.odd:
        f = formula(law.name, dof, math.sqrt)
        forth, back = ([f(design, s * w) for w in W.tolist()] for s in (1, -1))
        # the two springs swap roles, so their roundings of order 1 do
        assert np.allclose(forth, -np.array(back), rtol=0, atol=16 * EPS), dof


@pytest.mark.parametrize(
    ('law', 'dof'),
    [(name, dof) for name, law in RESTORING.items() for dof in DOFS if dof not in law.odd],
)
def test_the_other_laws_are_indeed_uneven(law, dof):
    f = formula(law, dof, math.sqrt)
    # far above rounding; the smallest, erratum E7, is (A L0 c - k3) 2 W²
    assert abs(f(PAPER_DESIGN, 0.4) + f(PAPER_DESIGN, -0.4)) > 1e-4


@pytest.mark.parametrize('law', [law for law in RESTORING if law != 'linear'])
@pytest.mark.parametrize('k3', [0.1, 0.5, 1.0])
def test_condition_16_makes_the_vertical_quasi_zero_stiff(law, k3):
    a = 0.5
    design = Design.of((1 + k3) * a / (1 - a), k3, math.sqrt(1 - a * a), 0.1)
    # terms of order A/a = 4 cancel
    assert abs(derivative(formula(law, 'vertical'), design, 0.0)) < 32 * EPS


@every_design
def test_closed_form_vertical_is_equation_8_less_the_weight(design):
    A, k3, L1 = design.A, design.k3, design.L1
    a = math.sqrt(1 - L1**2)  # erratum E2
    length = np.hypot(W, a)
    leaf, suspension = k3 * (a / length) * (W + L1), A * W * (1 - 1 / length)
    reference = W + suspension + leaf - k3 * L1
    for law in ('closed_form', 'corrected'):
        got = RESTORING[law].force(design, np.repeat(W[:, None], 4, axis=1))[:, 0]
        # hypot and sqrt round differently
        assert np.allclose(got, reference, rtol=0, atol=16 * EPS)


@every_design
@pytest.mark.parametrize('x', [-0.7, -0.1, 0.0, 0.3, 0.9])
def test_vertical_stiffness_is_equation_9_corrected(design, x):
    A, k3, L1, a = design.A, design.k3, design.L1, design.a
    cubed = math.hypot(x, a) ** 3
    stiffness = 1 + A + (-A * a**2 + k3 * a * (a**2 - x * L1)) / cubed  # erratum E1
    # 1 / a^3 = 8 magnifies the roundings
    assert derivative(formula('closed_form', 'vertical'), design, x) == pytest.approx(
        stiffness, abs=128 * EPS
    )


@every_design
@pytest.mark.parametrize('x', [-0.8, -0.2, 0.0, 0.1, 0.6])
def test_corrected_horizontal_force_is_the_slope_of_the_strain_energy(design, x):
    def energy(_, x):
        near, far = (cmath.sqrt((design.a - s * x) ** 2 + design.L1**2) for s in (1, -1))
        suspension = 0.5 * design.A * ((near - 1) ** 2 + (far - 1) ** 2)
        return suspension + 0.5 * (cmath.sqrt(x * x + design.L1**2) - design.L1) ** 2

    force = formula('corrected', 'horizontal', math.sqrt)(design, x)
    assert force == pytest.approx(derivative(energy, design, x), abs=32 * EPS)


def test_corrected_horizontal_stiffness_of_the_paper_design():
    stiffness = derivative(formula('corrected', 'horizontal'), PAPER_DESIGN, 0.0)
    assert stiffness == pytest.approx(2 * 1.1 * 0.5**2, abs=16 * EPS)  # 2 A a² = 0.55


def test_closed_form_horizontal_is_equation_11():
    A, L1, a = PAPER_DESIGN.A, PAPER_DESIGN.L1, PAPER_DESIGN.a
    l1, l2 = np.hypot(a - W, L1), np.hypot(a + W, L1)
    slope = 1 - L1 / np.hypot(W, L1) - A * (1 / l1 - 1 / l2)
    got = RESTORING['closed_form'].force(PAPER_DESIGN, np.repeat(W[:, None], 4, axis=1))[:, 1]
    assert np.allclose(got, A * a * (1 / l1 + 1 / l2 - 2) + W * slope, rtol=0, atol=16 * EPS)


@pytest.mark.parametrize('law', ['closed_form', 'corrected'])
def test_rotations_are_equations_13_and_15(law):
    A, k3, L0 = PAPER_DESIGN.A, PAPER_DESIGN.k3, PAPER_DESIGN.L0
    force = RESTORING[law].force(PAPER_DESIGN, np.repeat(W[:, None], 4, axis=1))
    # the lever s = L0 tan(phi) turns Eq (13) into sines and cosines
    phi = np.arctan(L0 * W)
    yaw = -A * (np.tan(phi) - np.sin(phi)) + k3 * np.sin(phi) * np.cos(phi)
    assert np.allclose(force[:, 2], yaw, rtol=0, atol=4 * EPS)
    c = np.cos(np.arcsin(W))
    pitch = (A * L0 * c - k3) * W * (W - c)
    if law == 'corrected':
        mirrored = (A * L0 * c - k3) * -W * (-W - c)
        pitch = (pitch - mirrored) / 2
    # arcsin is ill-conditioned near 1, by 1/c = 3
    assert np.allclose(force[:, 3], pitch, rtol=0, atol=4 * EPS)


@pytest.mark.parametrize('law', ['closed_form', 'corrected', 'symmetric'])
def test_table_1_tips_over_horizontally(law):
    # erratum E7: k3 - A L0 = 0.1 - 0.11
    stiffness = derivative(formula(law, 'horizontal_rotation'), PAPER_DESIGN, 0.0)
    assert stiffness == pytest.approx(-0.01, abs=4 * EPS)


def test_linear_law_is_linear():
    law = RESTORING['linear']
    k3, L0 = PAPER_DESIGN.k3, PAPER_DESIGN.L0
    stiffness = np.array([k3, k3, k3 * L0, k3])
    force = law.force(PAPER_DESIGN, np.repeat(W[:, None], 4, axis=1))
    assert np.allclose(force, W[:, None] * stiffness, rtol=2 * EPS)


def test_derived_ratios_of_a_design():
    design = Design.of(1.0, 0.2, 0.6, 0.1)
    assert (design.a, design.b) == (pytest.approx(0.8, rel=2 * EPS), pytest.approx(0.12))


def test_laws_stand_under_their_own_name():
    assert all(law.name == name and law.source for name, law in RESTORING.items())
