"""The coupled platform's forces: one energy, Eq (8) on the axis, symmetry, equilibrium, modes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from qzs_rig import scenario
from qzs_rig.errors import InputError
from qzs_rig.mechanics.equilibrium import (
    cautions,
    elastic,
    equilibrium,
    gradient,
    mass,
    modes,
    potential,
    stiffness,
)
from qzs_rig.mechanics.geometry import SIX, Geometry, rotation
from qzs_rig.mechanics.platform import Platform
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.rigid_body import wrench
from qzs_rig.units import DOFS, GRAVITY

CASES = {
    'Table 1': {},
    'a relaxed central spring': {'L10': 0.3},
    'ball joints, high payload': {'hinge': 0.0, 'cm_height': 0.15},
    'off condition (16)': {'A': 0.8, 'k3_hat': 0.3, 'L1_hat': 0.7, 'L0_hat': 0.15},
    'too heavy': {'m': 35.0, 'payload_trim': 15.0, 'cm_height': -0.05},
}
QZS = [(1.1, 0.1), (1.5, 0.5), (2.0, 1.0)]
"""(A, k3) that meet condition (16) at a = 1/2."""

every_case = pytest.mark.parametrize('case', CASES.values(), ids=CASES)


def spec_of(**given):
    words = {f'platform.{name}': value for name, value in given.items()}
    return scenario.of({'platform.law': 'geometric', **words})


def geometry_of(**given) -> Geometry:
    return Geometry.from_spec(spec_of(**given))


def poses(n=20, seed=0):
    """Large ones: 12 cm and 0.35 rad either way, the other half of the way to the anchors."""
    size = np.array([0.12, 0.12, 0.35, 0.35, 0.12, 0.35])
    return np.random.default_rng(seed).uniform(-1, 1, (n, 6)) * size


def push(geometry, pose):
    """Force and torque (6,) of the springs at `pose`."""
    z, x, yaw, pitch, y, roll = pose
    turn = rotation(yaw, pitch, roll)
    axes = (*turn[:, 0].tolist(), *turn[:, 1].tolist())
    return np.array(wrench(math.sqrt, geometry.springs, (x, y, z), axes))


@every_case
def test_the_axis_is_equation_8(case):
    geometry, platform = geometry_of(**case), Platform.from_spec(spec_of(**case))
    A, k3, L1, _, a, _ = platform.design
    x = np.linspace(-0.95, 0.45, 141)  # a central spring of natural length ends at x = L10
    length = np.hypot(x, a)
    equation_8 = x + A * x * (1 - 1 / length) + k3 * (a / length) * (x + L1)
    got = np.array([push(geometry, [-w * geometry.L20, 0, 0, 0, 0, 0]) for w in x])
    # the tolerance; some 10 roundings of order 1
    assert np.allclose(got[:, 2] / (geometry.k1 * geometry.L20), equation_8, rtol=0, atol=1e-12)
    assert not got[:, [0, 1, 3, 4, 5]].any()  # exactly: opposite arms are mirror images


@every_case
def test_the_force_is_the_slope_of_the_energy(case):
    geometry = geometry_of(**case)
    for pose in poses():
        step = 1e-150j * np.eye(6)
        slope = [potential(geometry, pose + step[n]).imag / 1e-150 for n in range(6)]
        # exact to rounding of terms of order k1 L20 = 1e4 N, k1 L20² = 7e3 N m
        assert np.allclose(gradient(geometry, pose), slope, rtol=0, atol=1e-10)


@every_case
def test_stiffness_is_symmetric_and_the_slope_of_the_force(case):
    geometry = geometry_of(**case)
    for pose in poses(5):
        K = stiffness(geometry, pose)
        # order 1e5 N/m next to anchors
        assert np.allclose(K, K.T, rtol=0, atol=1e-9)
        h = 1e-5
        steps = h * np.eye(6)
        slope = [gradient(geometry, pose + s) - gradient(geometry, pose - s) for s in steps]
        # central difference: h² times the fourth derivative, some 1e7
        assert np.allclose(K, np.array(slope).T / (2 * h), rtol=0, atol=1e-2)


@every_case
@pytest.mark.parametrize('quarter', [1, 2, 3])
def test_a_quarter_turn_changes_nothing(case, quarter):
    """Fourfold symmetry: the same motion seen from the next arm."""
    geometry = geometry_of(**case)
    turned = np.round(Rotation.from_euler('z', 90 * quarter, degrees=True).as_matrix())
    for pose in poses():
        centre, plate = np.array([pose[1], pose[4], pose[0]]), rotation(*pose[[2, 3, 5]])
        there, aligned = turned @ centre, turned @ plate @ turned.T
        before, after = elastic(geometry, centre, plate), elastic(geometry, there, aligned)
        assert after == pytest.approx(before, rel=1e-14)  # the arms add up in another order
        axes = (*aligned[:, 0].tolist(), *aligned[:, 1].tolist())
        got = np.array(wrench(math.sqrt, geometry.springs, tuple(there), axes)).reshape(2, 3)
        expected = push(geometry, pose).reshape(2, 3) @ turned.T
        assert np.allclose(got, expected, rtol=0, atol=1e-10)


@every_case
def test_the_mirror_image_pulls_the_mirror_way(case):
    geometry = geometry_of(**case)
    for z, x, yaw, pitch, y, roll in poses():
        force = push(geometry, [z, x, yaw, pitch, y, roll])
        mirrored = push(geometry, [z, x, -yaw, pitch, -y, -roll])  # in the x-z plane
        signs = np.array([1, -1, 1, -1, 1, -1])  # a torque is an axial vector
        assert np.allclose(mirrored, signs * force, rtol=0, atol=1e-10)


@pytest.mark.parametrize('case', [{}, CASES['off condition (16)']], ids=['Table 1', 'off (16)'])
@pytest.mark.parametrize('dof', range(4), ids=DOFS)
def test_the_four_projections_are_the_coupled_force(case, dof):
    geometry, platform = geometry_of(**case), Platform.from_spec(spec_of(**case))
    reach = (0.9, 0.95 * platform.design.a, 3.0, 3.0)[dof]
    w = np.linspace(-reach, reach, 61)
    law = platform.law.force(platform.design, np.repeat(w[:, None], 4, axis=1))[:, dof]
    scale = platform.stiffness[dof] * platform.length[dof]
    for point, force in zip(w, law, strict=True):
        pose = np.zeros(6)
        pose[dof] = point * platform.length[dof]
        # pitch stays below pi/2 by its axis, so that the slope along it is the torque
        coupled = push(geometry, pose)[[2, 0, 5, 4][dof]]
        balance = geometry.k3 * geometry.L1 if dof == 0 else 0.0
        # 1e-12 of k1 L20 and k1 L20²: the tolerance
        assert coupled - balance == pytest.approx(-scale * force, abs=1e-12 * 2e4)


@pytest.mark.parametrize('dof', range(4), ids=DOFS)
def test_stiffness_of_the_projections(dof):
    (design, h), law = (Platform.from_spec(spec_of()).design, 1e-5), RESTORING['geometric']
    force, w = law.along(dof), np.linspace(-0.45, 0.45, 41)
    # central differences: h² and eps / h
    slope = (force(design, w + h) - force(design, w - h)) / (2 * h)
    assert np.allclose(law.stiffness_along(dof)(design, w), slope, rtol=0, atol=1e-8)


@pytest.mark.parametrize(('A', 'k3'), QZS)
def test_ball_joints_let_every_qzs_platform_fall_over(A, k3):
    """Under (16) the compressed springs turn the plate out, whatever the design."""
    geometry = geometry_of(A=A, k3_hat=k3, hinge=0.0)
    L0, a, unit = 0.1, 0.5, geometry.k1 * geometry.L20**2
    K = stiffness(geometry, np.zeros(6))
    assert K[2, 2] == pytest.approx(-(1 + k3) * L0 * (L0 + a) * unit, rel=1e-12)
    assert K[3, 3] == pytest.approx(0.5 * L0 * (k3 * L0 - (1 + k3) * (L0 + a)) * unit, rel=1e-12)
    assert not modes(geometry).stable
    assert 'falls over' in cautions(geometry, True)[0]
    held = geometry_of(A=A, k3_hat=k3)
    assert modes(held).stable
    assert 'platform.hinge is unset' in cautions(held, False)[0]
    assert cautions(held, True) == []


@pytest.mark.parametrize('A', [0.8, 1.1, 2.0])
def test_yaw_of_equation_13_belongs_to_the_unloaded_state(A):
    """Erratum E25: without a term of A the suspension springs are unstressed, L1 higher up."""
    geometry = geometry_of(A=A, hinge=0.0)
    design, unit = Platform.from_spec(spec_of(A=A)).design, geometry.k1 * geometry.L20**2
    assert RESTORING['closed_form'].taylor(design)[2][0] == design.k3 * design.L0
    unloaded = stiffness(geometry, np.array([geometry.L1, 0, 0, 0, 0, 0]))
    # terms of order 1 cancel
    assert unloaded[2, 2] / unit == pytest.approx(0.0, abs=1e-14)
    expected = -A * (1 / design.a - 1) * design.L0 * (design.L0 + design.a)
    assert stiffness(geometry, np.zeros(6))[2, 2] / unit == pytest.approx(expected, rel=1e-12)


def test_the_leaf_preload_of_table_1_carries_106_kg():
    """Erratum E28: the levelling force takes the rest off."""
    geometry = geometry_of()
    carried = push(geometry, np.zeros(6))[2]
    assert carried == pytest.approx(1039.2, abs=0.05)  # digits quoted
    assert carried / GRAVITY == pytest.approx(106.0, abs=0.05)
    assert carried + geometry.level == pytest.approx(50 * GRAVITY, rel=1e-14)


def test_a_trim_moves_and_weighs_and_is_not_balanced():
    bare, loaded = geometry_of(), geometry_of(payload_trim=7.0)
    assert loaded.level == bare.level
    assert loaded.mass == bare.mass + 7.0
    pull = gradient(loaded, np.zeros(6)) - gradient(bare, np.zeros(6))
    assert pull == pytest.approx([7.0 * GRAVITY, 0, 0, 0, 0, 0], abs=1e-10)


def test_horizontal_stiffness_at_the_working_point():
    for L10, central in ((0.0, 1.0), (0.3, 0.0)):
        for A, L1 in ((1.1, math.sqrt(0.75)), (0.9, 0.7)):
            geometry = geometry_of(L10=L10, A=A, L1_hat=L1)
            a = math.sqrt(1 - L1**2)
            expected = (central + A * (1 - 1 / (2 * a))) * geometry.k1
            assert stiffness(geometry, np.zeros(6))[1, 1] == pytest.approx(expected, abs=1e-9)


def test_the_leaves_preload_couples_moving_aside_to_tilting():
    geometry = geometry_of()
    K = stiffness(geometry, np.zeros(6))
    coupling = 0.5 * geometry.k3 * geometry.L1 * geometry.L0 / geometry.span
    assert K[1, 3] == pytest.approx(coupling, rel=1e-12)
    assert K[4, 5] == pytest.approx(-coupling, rel=1e-12)  # +y tilts about -x
    pairs = {(pair.first, pair.second): pair for pair in modes(geometry).couplings}
    assert set(pairs) == {
        ('horizontal', 'horizontal_rotation'),
        ('horizontal_y', 'horizontal_rotation_x'),
    }


def test_a_high_payload_couples_through_its_mass():
    geometry = geometry_of(cm_height=0.1)
    found = modes(geometry)
    assert found.mass[1, 3] == pytest.approx(50 * 0.1, rel=1e-14)
    assert found.mass[3, 3] == pytest.approx(geometry.inertia_xy + 50 * 0.1**2, rel=1e-14)
    lower = modes(geometry_of())
    weight = 50 * 9.80665
    assert found.stiffness[3, 3] == pytest.approx(lower.stiffness[3, 3] - weight * 0.1, rel=1e-12)


def test_mass_is_the_kinetic_energy_of_the_moving_body():
    geometry, h = geometry_of(cm_height=0.15), 1e-6
    inertia = np.diag([geometry.inertia_xy] * 2 + [geometry.inertia_z])
    generator = np.random.default_rng(4)
    for pose in poses(5):
        speed = generator.uniform(-1, 1, 6)
        ahead, behind = pose + h * speed, pose - h * speed
        turns = [Rotation.from_euler('ZYX', q[[2, 3, 5]]) for q in (ahead, behind)]
        centres = [
            q[[1, 4, 0]] + turn.apply([0, 0, 0.15])
            for q, turn in zip((ahead, behind), turns, strict=True)
        ]
        velocity = (centres[0] - centres[1]) / (2 * h)
        spin = (turns[1].inv() * turns[0]).as_rotvec() / (2 * h)
        energy = 0.5 * geometry.mass * velocity @ velocity + 0.5 * spin @ inertia @ spin
        # central differences: eps / h
        assert 0.5 * speed @ mass(geometry, pose) @ speed == pytest.approx(energy, rel=1e-8)


@every_case
def test_modes_solve_their_equation(case):
    found = modes(geometry_of(**case))
    residual = found.stiffness @ found.shapes - found.mass @ found.shapes * found.squares
    assert np.abs(residual).max() < 1e-8 * np.abs(found.stiffness).max()
    assert np.allclose(found.shares.sum(axis=0), 1.0, atol=1e-12)
    swings = [f is None for f in found.frequencies_hz]
    assert swings == [g is not None for g in found.growth]


@pytest.mark.parametrize('trim', [-70.0, -20.0, -0.01, 0.0, 0.01, 5.0, 30.0])
def test_a_payload_rests_where_equation_8_carries_it(trim):
    spec = spec_of(m=100.0, payload_trim=trim)
    geometry, platform = Geometry.from_spec(spec), Platform.from_spec(spec)
    rest = equilibrium(geometry)
    # at the working point the stiffness is nil: rounding 1e-13 leaves its cube root
    expected = platform.rest[0] * platform.length[0]
    assert rest.pose[0] == pytest.approx(expected, rel=1e-6, abs=2e-5)
    assert not rest.pose[1:].any()
    assert np.abs(gradient(geometry, rest.pose)).max() < 1e-8


def test_an_uneven_start_falls_to_a_stable_rest():
    """A relaxed central spring lets the plate slide aside until the arms hold it."""
    geometry = geometry_of(L10=0.3, k3_hat=0.3, A=1.3, cm_height=0.05)
    saddle = modes(geometry)
    start = 0.05 * saddle.shapes[:, 0] / np.abs(saddle.shapes[:, 0]).max()
    rest = equilibrium(geometry, start)
    assert potential(geometry, rest.pose) <= potential(geometry, np.zeros(6)) + 1e-9
    curvature = np.linalg.eigvalsh(stiffness(geometry, rest.pose))
    assert curvature.min() > -1e-6 * curvature.max()


def test_a_payload_that_nothing_holds_is_refused():
    with pytest.raises(InputError, match=r'no equilibrium near .* bring platform\.payload_trim'):
        equilibrium(geometry_of(payload_trim=1950.0))


def test_six_begins_with_the_four():
    assert SIX[:4] == DOFS


@pytest.mark.parametrize('name', ['L10', 'hinge', 'cm_height'])
def test_what_single_degrees_of_freedom_cannot_mean_is_refused(name):
    with pytest.raises(InputError, match=rf'platform\.{name} = 0\.1 has no meaning .*coupled'):
        Platform.from_spec(spec_of(coupled=False, **{name: 0.1}))
    assert not Platform.from_spec(spec_of(coupled=False)).coupled
