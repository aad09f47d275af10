"""The coupled plate in motion: rigid body kinematics, energy, order, linear limit, same bits."""

from __future__ import annotations

import math
import sys
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.integrate._ivp import dop853_coefficients as dop853
from scipy.spatial.transform import Rotation

from qzs_rig import scenario
from qzs_rig.errors import DivergenceError, InputError
from qzs_rig.mechanics import rigid_body
from qzs_rig.mechanics.coupled_integrator import CoupledIntegrator, base_rows, body
from qzs_rig.mechanics.equilibrium import elastic, gradient, mass, modes, potential
from qzs_rig.mechanics.geometry import Geometry, angles, axes_of, quaternion
from qzs_rig.mechanics.integrator import Integrator
from qzs_rig.mechanics.platform import Platform
from qzs_rig.run import in_process
from qzs_rig.run.stages import SIX_CHANNELS, ExciterStage, PlatformStage
from qzs_rig.sensing.imu import specific_force_and_rate
from qzs_rig.units import GRAVITY

SIZE = np.array([0.03, 0.02, 0.1, 0.08])  # m, m, rad, rad
TONES = np.array([[9.0, 14.0], [8.0, 15.0], [7.0, 16.0], [6.0, 17.0]])  # rad/s
LARGE = {'I_vm': 2.0, 'I_hm': 1.5, 'cm_height': 0.1}
"""A payload of some width: all modes within 1 to 4 Hz."""
STILL = np.zeros(rigid_body.BASE)


def geometry_of(**given) -> Geometry:
    words = {f'platform.{name}': value for name, value in {**LARGE, **given}.items()}
    return Geometry.from_spec(scenario.of({'platform.law': 'geometric', **words}))


def base_at(t, size=SIZE):
    """Smooth base motion (n, 8), two tones a degree of freedom."""
    t = np.asarray(t, dtype=float)[:, None]
    first, second = TONES.T
    x = size * (np.sin(first * t) + 0.5 * np.cos(second * t))
    v = size * (first * np.cos(first * t) - 0.5 * second * np.sin(second * t))
    return np.hstack([x, v])


def integrate(geometry, step, base, substeps=1, kernel='auto', chunk=None):
    integrator = CoupledIntegrator(geometry, step, substeps, kernel)
    chunk = chunk or len(base)
    return np.vstack([integrator.push(base[k : k + chunk]) for k in range(0, len(base), chunk)])


def energy(geometry, states):
    """Energy (n,) of states on a base at rest."""
    g, total = geometry, []
    for state in np.atleast_2d(states):
        axes = axes_of(state[None, 6:10])
        turn = np.stack([axis[0] for axis in axes], axis=1)
        centre = state[:3] - g.height * turn[:, 2]
        wx, wy, wz = state[10:]
        kinetic = 0.5 * g.mass * state[3:6] @ state[3:6]
        kinetic += 0.5 * (g.inertia_xy * (wx**2 + wy**2) + g.inertia_z * wz**2)
        still = g.mass * GRAVITY * state[2] - g.level * centre[2]
        total.append(kinetic + elastic(g, centre, turn) + still)
    return np.array(total)


def state_of(pose, spin=(0.0, 0.0, 0.0), height=0.0, velocity=(0.0, 0.0, 0.0)):
    q = quaternion(pose[2], pose[3], pose[5])
    up = axes_of(q[None])[2][0]
    centre = np.array([pose[1], pose[4], pose[0]]) + height * up
    return tuple(map(float, (*centre, *velocity, *q, *spin)))


@cache
def eighth_order():
    """Dormand and Prince's 8th order method at fixed step, compiled, from scipy's tableau."""
    import numba

    rigid_body.compiled()
    rates = numba.njit(rigid_body.rates)
    A = np.ascontiguousarray(dop853.A[:12, :12])
    B = np.ascontiguousarray(dop853.B)

    @numba.njit
    def tuple_of(s):
        return (s[0], s[1], s[2], s[3], s[4], s[5], s[6], s[7], s[8], s[9], s[10], s[11], s[12])

    @numba.njit
    def run(springs, body, base, start, h, steps, every):
        state, now = start.copy(), start.copy()
        kept = np.empty((steps // every, 13))
        k = np.empty((12, 13))
        for n in range(steps):
            for stage in range(12):
                now[:] = state
                for before in range(stage):
                    share = h * A[stage, before]
                    for c in range(13):
                        now[c] += share * k[before, c]
                slope = rates(math.sqrt, springs, body, base, tuple_of(now))
                for c in range(13):
                    k[stage, c] = slope[c]
            for stage in range(12):
                share = h * B[stage]
                for c in range(13):
                    state[c] += share * k[stage, c]
            state[6:10] /= math.sqrt((state[6:10] ** 2).sum())
            if (n + 1) % every == 0:
                kept[n // every] = state
        return kept

    return run


def test_energy_is_conserved_over_ten_thousand_periods():
    """Of the slowest mode, by an 8th order method with 40 steps a period of the fastest one: its
    own loss is near 1e-10. A is off condition (16), where the slowest would take forever."""
    geometry = geometry_of(A=0.6, hinge=1000.0)
    frequencies = modes(geometry).frequencies_hz
    undamped = (*body(geometry)[:4], 0.0, 0.0, 0.0, 0.0, *body(geometry)[8:])
    start = state_of([0.05, 0.03, 0.1, 0.08, -0.02, 0.05], (0.3, -0.2, 0.4), geometry.height)
    step = 1.0 / (40 * max(frequencies))
    steps = round(1e4 / min(frequencies) / step)
    kept = eighth_order()(
        geometry.springs, undamped, STILL, np.array(start), step, steps, steps // 200
    )
    total = energy(geometry, np.vstack([start, kept]))
    floor = float(energy(geometry, state_of(np.zeros(6), height=geometry.height))[0])
    assert np.abs(total - total[0]).max() < 1e-9 * (total[0] - floor)
    assert (np.ptp(kept[:, :3], axis=0) > 0.03).all(), 'it still swings in all directions'


def test_damping_takes_energy_away():
    geometry = geometry_of()
    start = state_of([0.03, 0.02, 0.1, 0.08, -0.02, 0.05], height=geometry.height)
    n = 2000
    rows = [STILL.tolist()] * (n + 1)
    states, slopes = [()] * n, [()] * n
    plant = body(geometry)
    assert (
        rigid_body.march(geometry.springs, plant, 1e-3, start, rows, rows[1:], states, slopes) == n
    )
    total = energy(geometry, np.array(states))
    assert (np.diff(total) < 0).all()
    # dE/dt is minus the dampers' power, with rates relative to a base at rest
    state = np.array(states[700])
    axes = np.stack([axis[0] for axis in axes_of(state[None, 6:10])], axis=1)
    spin = axes @ state[10:]
    velocity = state[3:6] - geometry.height * np.cross(spin, axes[:, 2])
    Cz, Cxy, Cyaw, Ctilt = geometry.damping
    power = np.array([Cxy, Cxy, Cz]) @ velocity**2 + np.array([Ctilt, Ctilt, Cyaw]) @ spin**2
    assert (total[699] - total[701]) / 2e-3 == pytest.approx(power, rel=1e-4)


def test_a_body_without_springs_moves_freely():
    """Torque-free symmetric top: angular momentum stays, the axis precesses at L / I."""
    springs = (0.0,) * 4 + (0.5, 0.06, 0.36, 0.0, 0.0, 0.0)
    m, Iz, Ixy = 50.0, 2.0, 1.5
    plant = (m, 0.0, Iz, Ixy, 0.0, 0.0, 0.0, 0.0, 0.0, GRAVITY)
    start = np.array([0, 0, 0, 0.1, -0.2, 0.3, *quaternion(0.3, 0.2, 0.1), 0.5, 0.7, 2.0])
    n, h = 2000, 1e-3
    rows = [STILL.tolist()] * (n + 1)
    states, slopes = [()] * n, [()] * n
    rigid_body.march(springs, plant, h, tuple(start.tolist()), rows, rows[1:], states, slopes)
    last, t = np.array(states[-1]), n * h
    fall = np.array([0, 0, -0.5 * GRAVITY * t**2])
    assert np.allclose(last[:3], start[3:6] * t + fall, rtol=0, atol=1e-10)
    turns = [Rotation.from_quat(s[[7, 8, 9, 6]]) for s in (start, last)]
    momentum = [
        turn.apply(np.array([Ixy, Ixy, Iz]) * s[10:])
        for turn, s in zip(turns, (start, last), strict=True)
    ]
    # RK4: (omega h)^4 / 120 = 2e-13 a radian
    assert np.allclose(*momentum, rtol=0, atol=1e-10)
    size = np.linalg.norm(momentum[0])
    precessed = Rotation.from_rotvec(momentum[0] / size * (size / Ixy) * t)
    axis = turns[0].apply([0, 0, 1])
    assert np.allclose(precessed.apply(axis), turns[1].apply([0, 0, 1]), rtol=0, atol=1e-9)


def test_small_free_motion_is_the_modes():
    geometry = geometry_of(m=45.0, payload_trim=5.0)
    found = modes(geometry)
    undamped = (*body(geometry)[:4], 0.0, 0.0, 0.0, 0.0, *body(geometry)[8:])
    h, n = 1e-3, 1000
    rows = [STILL.tolist()] * (n + 1)
    for mode in range(6):
        w = math.sqrt(found.squares[mode])
        shape = 1e-7 * found.shapes[:, mode] / np.abs(found.shapes[:, mode]).max()
        start = state_of(found.rest.pose + shape, height=geometry.height)
        states, slopes = [()] * n, [()] * n
        rigid_body.march(geometry.springs, undamped, h, start, rows, rows[1:], states, slopes)
        end = np.array(states[-1])
        expected = state_of(found.rest.pose + shape * math.cos(w * n * h), height=geometry.height)
        # second order in 1e-7
        assert np.allclose(end[[0, 1, 2, 6, 7, 8, 9]], np.array(expected)[[0, 1, 2, 6, 7, 8, 9]],
                           rtol=0, atol=1e-11)  # fmt: skip


def test_the_equations_of_motion_are_lagranges():
    """M(q) q'' + dM/dt q' - dT/dq = -dV/dq, with M and V formed independently of the kernel."""
    geometry, generator, h = geometry_of(), np.random.default_rng(5), 1e-5
    plant = (*body(geometry)[:4], 0.0, 0.0, 0.0, 0.0, *body(geometry)[8:])
    for _ in range(5):
        pose = generator.uniform(-1, 1, 6) * [0.1, 0.1, 0.3, 0.3, 0.1, 0.3]
        speed = generator.uniform(-1, 1, 6)
        M = mass(geometry, pose)
        along = [mass(geometry, pose + h * e) - mass(geometry, pose - h * e) for e in np.eye(6)]
        dM = np.array(along) / (2 * h)
        kinetic = 0.5 * np.einsum('kij,i,j->k', dM, speed, speed)
        quick = np.einsum('kij,k,j->i', dM, speed, speed)
        expected = np.linalg.solve(M, kinetic - quick - gradient(geometry, pose))
        turns = [Rotation.from_euler('ZYX', (pose + s * h * speed)[[2, 3, 5]]) for s in (1, -1)]
        spin = (turns[1].inv() * turns[0]).as_rotvec() / (2 * h)
        tops = [t.apply([0, 0, geometry.height]) for t in turns]
        velocity = speed[[1, 4, 0]] + (tops[0] - tops[1]) / (2 * h)
        state = state_of(pose, spin, geometry.height, velocity)
        slope = np.array(rigid_body.rates(math.sqrt, geometry.springs, plant, STILL, state))
        got = angles(np.array([state[6:10]]), spin[None], slope[None, 10:]).acceleration[0]
        # central differences of order 1 with step 1e-5, magnified by 1 / I
        assert np.allclose(got, expected[[2, 3, 5]], rtol=1e-6, atol=1e-5)


def test_angles_and_their_derivatives():
    """Against scipy's rotations and central differences along a wild tumble."""
    h, t = 1e-4, np.linspace(0, 2, 50)

    def at(t):
        return np.stack([2.5 * np.sin(t), np.sin(1.3 * t), 1.5 * np.cos(0.7 * t)], axis=1)

    def spin(t):
        ahead, behind = (Rotation.from_euler('ZYX', at(t + s * h)) for s in (1, -1))
        return (behind.inv() * ahead).as_rotvec() / (2 * h)

    attitude = np.array([quaternion(*row) for row in at(t)])
    reference = Rotation.from_euler('ZYX', at(t)).as_quat()[:, [3, 0, 1, 2]]
    same = np.sign((attitude * reference).sum(axis=1))[:, None]
    assert np.allclose(attitude * same, reference, rtol=0, atol=1e-15)
    got = angles(attitude, spin(t), (spin(t + h) - spin(t - h)) / (2 * h))
    assert np.allclose(got.angle, at(t), rtol=0, atol=1e-14)
    # central differences: h² and eps / h², and a singularity at pitch pi / 2 not far
    assert np.allclose(got.rate, (at(t + h) - at(t - h)) / (2 * h), rtol=0, atol=1e-6)
    bend = (at(t + h) - 2 * at(t) + at(t - h)) / h**2
    assert np.allclose(got.acceleration, bend, rtol=0, atol=1e-5)


def test_order_is_four_with_the_base_turning():
    geometry = geometry_of()
    ends = [
        integrate(geometry, 1.0 / n, base_at(np.linspace(0, 1, n + 1)))[-1]
        for n in (200, 400, 800, 1600)
    ]
    coarse, fine, finest = np.abs(np.diff(ends, axis=0))
    for column in (0, 1, 2, 3, 12, 13):
        # Richardson: the next term of the error is one order higher, 0.2 at these steps
        assert math.log2(fine[column] / finest[column]) == pytest.approx(4, abs=0.3), column
    assert (coarse[:4] > fine[:4]).all()


def test_the_output_is_its_own_derivative():
    geometry, h = geometry_of(), 1e-3
    top = integrate(geometry, h, base_at(h * np.arange(1000)))
    for position, velocity, acceleration in (
        *((k, 4 + k, 8 + k) for k in range(4)),
        *((12 + k, 14 + k, 16 + k) for k in range(2)),
    ):
        for x, v in ((position, velocity), (velocity, acceleration)):
            slope = (top[2:, x] - top[:-2, x]) / (2 * h)
            size = np.abs(top[:, v]).max()
            # central difference: (omega h)² / 6 at some 40 rad/s
            assert np.abs(slope - top[1:-1, v]).max() < 1e-3 * size


def test_motion_up_and_down_is_the_single_degree_of_freedom():
    """The axis is Eq (8) in motion too: all else stays exactly zero."""
    spec = scenario.of({'platform.law': 'geometric'})
    base = np.zeros((2000, 8))
    t = 2e-3 * np.arange(2000)
    base[:, 0], base[:, 4] = 0.02 * np.sin(12 * t), 0.24 * np.cos(12 * t)
    coupled = integrate(Geometry.from_spec(spec), 2e-3, base)
    single = Integrator(Platform.from_spec(spec), 2e-3, 1, 'auto').push(base)
    # the same method on the same equation, scaled otherwise: rounding over 4000 stages
    assert np.allclose(coupled[:, 0], single[:, 0], rtol=0, atol=1e-12)
    assert np.allclose(coupled[:, 8], single[:, 8], rtol=0, atol=1e-9)
    others = [k for k in range(18) if k not in (0, 4, 8)]
    assert not coupled[:, others].any()


def test_a_base_turned_by_a_right_angle_turns_the_motion():
    """The rig knows no compass: yaw the base by 90 degrees and x becomes y."""
    geometry, t = geometry_of(), 1e-3 * np.arange(800)
    base = np.zeros((len(t), 8))
    base[:, 1], base[:, 5] = 0.03 * np.sin(10 * t), 0.3 * np.cos(10 * t)
    plain = integrate(geometry, 1e-3, base)
    base[:, 2] = math.pi / 2
    turned = integrate(geometry, 1e-3, base)
    # four arms, every quarter turn alike; in its own axes the plate now tilts about x
    assert np.allclose(turned[:, [0, 1]], plain[:, [0, 1]], rtol=0, atol=1e-10)
    assert np.allclose(turned[:, 13], plain[:, 3], rtol=0, atol=1e-9)
    assert np.abs(plain[:, 3]).max() > 1e-3


def test_a_steadily_moving_base_carries_the_plate_along():
    geometry, t = geometry_of(m=40.0, payload_trim=10.0), 1e-3 * np.arange(500)
    base = np.zeros((len(t), 8))
    base[:, 1], base[:, 5] = 0.7 * t, 0.7
    base[:, 0], base[:, 4] = 0.2 * t, 0.2
    top = integrate(geometry, 1e-3, base)
    rest = integrate(geometry, 1e-3, np.zeros_like(base))
    assert np.allclose(top[:, :2], rest[:, :2] + base[:, :2], rtol=0, atol=1e-12)
    # x of either side is rounded alone
    assert np.abs(top[:, [2, 3, 12, 13]]).max() < 1e-12


def test_an_independent_solver_agrees():
    geometry, step, n = geometry_of(), 1e-3, 1500
    t = step * np.arange(n + 1)
    plant = body(geometry)

    def slope(moment, state):
        row = base_rows(base_at([moment]))[0]
        return rigid_body.rates(math.sqrt, geometry.springs, plant, row, tuple(state))

    top = integrate(geometry, step, base_at(t))
    integrator = CoupledIntegrator(geometry, step, 1, 'python')
    integrator.push(base_at(t[:1]))
    start = integrator._state
    solved = solve_ivp(slope, (0, t[-1]), start, 'DOP853', t_eval=t[::100], rtol=1e-11, atol=1e-12)
    states = solved.y.T
    centre = states[:, :3] - geometry.height * axes_of(states[:, 6:10])[2]
    # RK4 and the Hermite cubic: (omega h)^4 / 384 at 40 rad/s is 7e-9, over 60 radians
    assert np.allclose(top[::100, [1, 12, 0]], centre, rtol=0, atol=1e-7)


@pytest.mark.parametrize('kernel', ['python', 'numba'])
@pytest.mark.parametrize('substeps', [1, 3])
def test_chunks_do_not_change_a_bit(kernel, substeps):
    base = base_at(2e-3 * np.arange(301))
    whole = integrate(geometry_of(), 2e-3, base, substeps, kernel)
    for chunk in (1, 7, 50, 1000):
        cut = integrate(geometry_of(), 2e-3, base, substeps, kernel, chunk)
        assert cut.tobytes() == whole.tobytes()


@pytest.mark.parametrize('size', [SIZE, SIZE * [1, 1, 0, 0]], ids=['turning', 'level'])
def test_the_interpreter_and_numba_give_the_same_bits(size):
    base = base_at(2e-3 * np.arange(1001), size)
    plain, fast = (
        integrate(geometry_of(L10=0.3), 2e-3, base, 1, kernel) for kernel in ('python', 'numba')
    )
    assert plain.tobytes() == fast.tobytes()


def test_no_samples_give_no_samples():
    assert CoupledIntegrator(geometry_of(), 1e-3, 1, 'python').push(np.empty((0, 8))).shape == (
        0,
        18,
    )


@pytest.mark.parametrize('kernel', ['python', 'numba'])
@pytest.mark.parametrize('chunk', [1, 64, 4000])
def test_a_plate_that_falls_over_ends_the_run(kernel, chunk):
    base = base_at(1e-3 * np.arange(4000), SIZE * [1, 1, 0, 0])
    with pytest.raises(
        DivergenceError, match=r'turned more than 1 rad .* raise platform\.hinge'
    ) as e:
        integrate(geometry_of(hinge=0.0), 1e-3, base, 1, kernel, chunk)
    last = e.value.last_good_sample
    good = integrate(geometry_of(hinge=0.0), 1e-3, base[:last])
    assert np.isfinite(good).all()


@pytest.mark.parametrize('kernel', ['python', 'numba'])
def test_a_base_that_is_not_finite_is_a_divergence(kernel):
    base = base_at(1e-3 * np.arange(20))
    base[10:, 0] = np.nan
    with pytest.raises(DivergenceError, match='left the finite numbers after sample 9 '):
        integrate(geometry_of(), 1e-3, base, 3, kernel)


def test_numba_must_be_there_when_it_is_asked_for(monkeypatch):
    rigid_body.compiled.cache_clear()
    monkeypatch.setitem(sys.modules, 'numba', None)
    with pytest.raises(InputError, match=r"platform\.kernel = 'numba' needs numba"):
        CoupledIntegrator(geometry_of(), 1e-3, 1, 'numba')
    assert len(integrate(geometry_of(), 1e-3, base_at([0.0, 1e-3]), kernel='auto')) == 2


def test_a_sensor_on_the_coupled_plate_feels_all_six():
    motions = np.random.default_rng(3).uniform(-1, 1, (100, 18))
    plate = Rotation.from_euler('ZYX', motions[:, [2, 3, 13]])
    felt = np.column_stack([motions[:, 9], motions[:, 16], motions[:, 8] + GRAVITY])
    reading = specific_force_and_rate(motions)
    assert np.allclose(reading[:, 3:], plate.inv().apply(felt), rtol=0, atol=1e-13)
    h = 1e-5
    ahead, behind = (
        Rotation.from_euler('ZYX', motions[:, [2, 3, 13]] + s * h * motions[:, [6, 7, 15]])
        for s in (1, -1)
    )
    # central difference of the attitude: h² / 6 and eps / h
    turned = (behind.inv() * ahead).as_rotvec() / (2 * h)
    assert np.allclose(reading[:, :3], turned, rtol=0, atol=1e-9)
    level = motions.copy()
    level[:, 12:] = 0.0
    assert np.array_equal(specific_force_and_rate(level), specific_force_and_rate(motions[:, :12]))


def driven(**given):
    words = {'run.rate': 500, 'excitation.kind': 'sine', 'excitation.frequency': 4.0}
    words |= {'excitation.duration': 4.0, 'excitation.amplitude.horizontal': 0.5}
    return scenario.of({**words, 'platform.law': 'geometric', **given})


def test_the_platform_stage_moves_all_six():
    spec = driven(**{'platform.cm_height': 0.1})
    exciter, stage = ExciterStage(spec, 2_000_000), PlatformStage(spec, 2_000_000)
    out = stage.push(exciter.take(1000))
    assert out.top.channels == SIX_CHANNELS
    assert [c.name for c in SIX_CHANNELS[12:14]] == [
        'horizontal_y.position',
        'horizontal_rotation_x.position',
    ]
    top = out.top.data
    assert np.abs(top[:, 3]).max() > 1e-4  # pushed aside above its springs, it pitches
    assert not top[:, [2, 12, 13]].any()  # nothing drives it out of the x-z plane
    assert np.array_equal(out.top_imu.data, specific_force_and_rate(top))


def test_uncoupled_is_the_projection():
    spec = driven(**{'platform.coupled': False})
    base = ExciterStage(spec, 2_000_000).take(500)
    out = PlatformStage(spec, 2_000_000).push(base)
    assert out.top.data.shape == (500, 12)
    assert not out.top.data[:, [0, 2, 3]].any()


def test_a_run_in_process_warns_and_estimates():
    result = in_process.run(driven())
    assert any('platform.hinge is unset' in caution for caution in result.cautions)
    assert {curve.dof for curve in result.estimate.curves} >= {'horizontal'}


def test_potential_counts_the_levelling_force():
    geometry = geometry_of()
    lifted = np.zeros(6)
    lifted[0] = 0.01
    rise = potential(geometry, lifted) - potential(geometry, np.zeros(6))
    springs = elastic(geometry, np.array([0, 0, 0.01]), np.eye(3))
    springs -= elastic(geometry, np.zeros(3), np.eye(3))
    assert rise == pytest.approx(springs + (50 * GRAVITY - geometry.level) * 0.01, rel=1e-9)
