"""Restoring laws: one value from every evaluator, symmetry, Taylor terms, strain energy."""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest

from qzs_rig.dof import DOFS
from qzs_rig.mechanics import marching
from qzs_rig.mechanics.design import PAPER_DESIGN, Design
from qzs_rig.mechanics.restoring import RESTORING

DESIGNS = {
    'paper': PAPER_DESIGN,
    'paper 1.5': Design.of(1.5, 0.5, math.sqrt(0.75), 0.1),
    'paper 2': Design.of(2.0, 1.0, math.sqrt(0.75), 0.1),
    'off condition (16)': Design.of(0.8, 0.3, 0.7, 0.15),
}
ODD = {
    'corrected': ('horizontal', 'vertical_rotation', 'horizontal_rotation'),
    'closed_form': ('vertical_rotation',),
    'symmetric': DOFS,
    'linear': DOFS,
    'geometric': ('horizontal', 'vertical_rotation', 'horizontal_rotation'),
}
"""Degrees of freedom in which a law pulls back alike on both sides (MODEL section 3)."""

W = np.linspace(-0.95, 0.95, 381)
EPS = np.finfo(float).eps

every_law = pytest.mark.parametrize('law', RESTORING.values(), ids=RESTORING)
every_design = pytest.mark.parametrize('design', DESIGNS.values(), ids=DESIGNS)
every_dof = pytest.mark.parametrize('dof', range(4), ids=DOFS)


def formula(law, dof, sqrt=cmath.sqrt):
    return RESTORING[law].bind(sqrt)[DOFS.index(dof)]


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
    scalar = [[f(design, w) for f in law.bind(math.sqrt)] for w in W.tolist()]
    assert np.array_equal(array, scalar)


@every_law
@every_dof
def test_compiled_evaluation_gives_the_same_bits(law, dof):
    compiled, plain = marching.compiled(law.name)[1][dof], law.bind(math.sqrt)[dof]
    for design in DESIGNS.values():
        got = [compiled(tuple(design), w) for w in W.tolist()]
        assert got == [plain(design, w) for w in W.tolist()]


@every_law
@every_design
def test_the_working_point_is_an_equilibrium(law, design):
    # terms of order 1 cancel there: a few roundings remain
    assert np.abs(law.force(design, np.zeros(4))).max() <= 8 * EPS


@every_law
@every_design
@every_dof
def test_cubic_coefficients_are_the_odd_taylor_terms(law, design, dof):
    function = law.bind(cmath.sqrt)[dof]
    c1, c3 = law.cubic(design)[dof]
    # values of order 0.2 divided by 0.2^3, summed over 64 points: some 1e3 roundings
    assert taylor(function, design, 1) == pytest.approx(c1, abs=1e-13)
    assert taylor(function, design, 3) == pytest.approx(c3, abs=1e-12)


@every_law
@every_design
def test_axisymmetric_motions_pull_back_alike_on_both_sides(law, design):
    for dof in ODD[law.name]:
        f = formula(law.name, dof, math.sqrt)
        forth, back = ([f(design, s * w) for w in W.tolist()] for s in (1, -1))
        # the two springs swap roles, so their roundings of order 1 do
        assert np.allclose(forth, -np.array(back), rtol=0, atol=16 * EPS), dof


@pytest.mark.parametrize(
    ('law', 'dof'),
    [(law, dof) for law, odd in ODD.items() for dof in DOFS if dof not in odd],
)
def test_the_other_laws_are_indeed_uneven(law, dof):
    f = formula(law, dof, math.sqrt)
    # far above rounding; the smallest, erratum E7, is (A L0 c - k3) 2 W²
    assert abs(f(PAPER_DESIGN, 0.4) + f(PAPER_DESIGN, -0.4)) > 1e-4


@pytest.mark.parametrize('law', ['corrected', 'closed_form', 'symmetric'])
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
    assert set(ODD) == set(RESTORING), 'a new law says here where it is odd'
