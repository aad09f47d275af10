"""Springs: the paper's formulas, Table 3, strength against textbook cases, and selection."""

from __future__ import annotations

import math

import pytest
from scipy.integrate import quad

from qzs_rig.errors import InputError
from qzs_rig.mechanics import spring_selection as selection
from qzs_rig.mechanics import springs
from qzs_rig.mechanics.spring_selection import Wanted
from qzs_rig.mechanics.springs import Helical, Leaf, Suspension

WANTED = {
    'compression': Wanted(5500.0, 0.06, 0.12, 0.3),
    'tension': Wanted(20000.0, 0.52, 0.25, 1.6, 'tension'),
    'guided': Wanted(22000.0, 0.05, 0.08, 0.3, ends='fixed'),
}
every_duty = pytest.mark.parametrize('wanted', WANTED.values(), ids=WANTED)


def test_rates_of_table_3():
    assert round(springs.CENTRAL.rate) == 19973
    assert round(springs.SUSPENSION.rate) == 22570


def test_leaf_rotation_is_mohrs_integral():
    leaf, force = Leaf(0.08, 0.002, 0.6), 7.0
    integral = quad(lambda x: force * x / (leaf.E * leaf.J), 0.0, leaf.length)[0]  # Eq (2)
    assert leaf.rotation(force) == pytest.approx(integral, rel=1e-14)
    assert leaf.force(leaf.rotation(force)) == pytest.approx(force, rel=1e-15)


def test_table_1_has_another_leaf_than_table_3():
    # erratum E9
    assert springs.PAPER_LEAF.stiffness == pytest.approx(98.77, abs=5e-3)
    leaf = Leaf.of_stiffness(2000.0, 0.08, 0.6)
    assert leaf.stiffness == pytest.approx(2000.0, rel=1e-14)
    assert 1e3 * leaf.h == pytest.approx(5.45, abs=5e-3)


def test_bending_stress_is_moment_over_section_modulus():
    leaf, force = Leaf(0.08, 0.005, 0.6), 260.0
    modulus = leaf.J / (leaf.h / 2)
    assert leaf.bending_stress(force) == pytest.approx(force * leaf.length / modulus, rel=1e-14)


def test_suspension_keeps_its_foot():
    spring = Suspension(22000.0, 0.6, math.pi / 3)
    for x in (0.0, 0.1, 0.6 * math.sin(math.pi / 3)):
        L1 = spring.length(x)
        alpha1 = math.acos(0.6 * math.cos(spring.alpha0) / L1)
        # Eq (4), both lines
        assert x == pytest.approx(0.6 * math.sin(spring.alpha0) - L1 * math.sin(alpha1), abs=1e-8)
        assert spring.force(x) == pytest.approx(22000.0 * (0.6 - L1), rel=1e-14)


def test_suspension_is_half_as_long_at_the_working_point_as_at_first():
    # a = 1/2: level, it is a L20
    spring = Suspension(1.0, 0.6, math.pi / 3)
    assert spring.length(0.6 * math.sqrt(0.75)) == pytest.approx(0.3, rel=1e-14)


def test_wahls_factor():
    # printed in spring tables to three digits: 1.40 at 4, 1.253 at 6, 1.145 at 10
    for index, factor in ((4, 1.404), (6, 1.253), (10, 1.145)):
        assert Helical(0.001, 0.001 * index, 10).wahl == pytest.approx(factor, abs=6e-4)


@pytest.mark.parametrize(('mm', 'rm'), [(1.0, 2230), (5.0, 1660), (10.0, 1410)])
def test_wire_strength_is_the_table_of_en_10270_1(mm, rm):
    # the standard's table is rounded to 10 MPa by classes of diameter
    assert 1e-6 * springs.tensile_strength(1e-3 * mm) == pytest.approx(rm, abs=15)


def test_a_stubby_or_stretched_spring_never_buckles():
    assert Helical(0.002, 0.02, 5).buckling_deflection(0.03, 'fixed') == math.inf
    assert Helical(0.002, 0.02, 5, 'tension').buckling_deflection(1.0, 'hinged') == math.inf


def test_a_very_slender_spring_buckles_as_an_euler_column():
    """s/L0 -> (pi D/(nu L0))² / (4 (0.5 + G/E)): the first term of the series."""
    spring = Helical(0.002, 0.02, 50)
    ratio = spring.G / 2.06e11
    slender = math.pi * spring.D / 10.0
    expected = 10.0 * slender**2 / (4.0 * (0.5 + ratio))
    # the next term is of relative order slender² = 4e-5
    assert spring.buckling_deflection(10.0, 'hinged') == pytest.approx(expected, rel=1e-4)


def test_the_springs_of_table_3_cannot_do_their_work():
    """Solid, the suspension spring is longer than at the working point; both are overstressed."""
    suspension = selection.check(springs.SUSPENSION, Wanted(22000.0, 0.3, 1.0, 0.6, tolerance=0.05))
    assert set(suspension.failures) == {'stress', 'solid', 'buckles'}
    assert suspension.spring.solid_length > 0.3
    central = selection.check(
        springs.CENTRAL, Wanted(20000.0, 0.52, 1.0, 0.77, 'tension', tolerance=0.05)
    )
    assert central.failures == ('stress',)
    assert central.stress > springs.tensile_strength(0.010)


@every_duty
def test_candidates_pass_every_check_lightest_first(wanted):
    found = selection.candidates(wanted)
    assert found
    masses = [c.spring.mass for c in found]
    assert masses == sorted(masses)
    for c in found:
        s = c.spring
        assert s.rate == pytest.approx(wanted.rate, rel=wanted.tolerance)
        assert 4 <= s.index <= 16
        assert s.outside <= wanted.outside
        assert any(math.isclose(1e3 * s.d, wire) for wire in selection.WIRES_MM)
        assert (4 * s.n).is_integer()
        force = s.rate * wanted.deflection
        assert s.wahl * 8 * force * s.D / (math.pi * s.d**3) <= s.allowable
        assert c.clearance >= (s.least_gap if s.kind == 'compression' else 0)
        assert c.buckles_at >= wanted.deflection


@every_duty
def test_more_room_never_loses_a_candidate(wanted):
    roomier = Wanted(
        *(wanted.rate, wanted.deflection, 1.2 * wanted.outside),
        wanted.length,
        wanted.kind,
        wanted.ends,
    )
    assert {c.spring for c in selection.candidates(wanted)} <= {
        c.spring for c in selection.candidates(roomier)
    }


def test_selection_is_deterministic():
    wanted = WANTED['compression']
    assert selection.candidates(wanted) == selection.candidates(wanted)


def test_leaves_have_the_rate_and_are_sorted_by_stress():
    found = selection.leaves(2000.0, 260.0, 0.6, 0.1)
    assert found
    assert [c.stress for c in found] == sorted(c.stress for c in found)
    for c in found:
        assert c.leaf.stiffness == pytest.approx(2000.0, rel=1e-14)
        assert c.leaf.b <= 0.1
        assert bool(c.failures) == (c.stress > selection.LEAF_ALLOWABLE)


@pytest.mark.parametrize('name', ['rate', 'deflection', 'outside', 'length', 'tolerance'])
@pytest.mark.parametrize('value', [0.0, -1.0, math.nan, math.inf])
def test_a_senseless_wish_is_refused(name, value):
    words = {'rate': 1e4, 'deflection': 0.01, 'outside': 0.1, 'length': 0.2, 'tolerance': 0.02}
    with pytest.raises(InputError, match=f'spring {name} = .* must be above 0'):
        Wanted(**(words | {name: value}))


def test_a_spring_cannot_be_compressed_by_its_length():
    with pytest.raises(InputError, match=r'0\.2 m long cannot give 0\.2 m; allow more length'):
        Wanted(1e4, 0.2, 0.1, 0.2)


def test_unknown_ends_are_refused():
    with pytest.raises(InputError, match="unknown ends 'glued'; known: fixed, hinged, free"):
        selection.known_ends('glued')
