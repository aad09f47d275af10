"""The integrator: order, energy, closed forms, an independent solver, and the same bits always."""

from __future__ import annotations

import math
import sys

import numpy as np
import pytest
from scipy.integrate import quad, romb, solve_ivp
from scipy.linalg import expm

from qzs_rig import scenario
from qzs_rig.errors import DivergenceError, InputError
from qzs_rig.mechanics.integrator import Integrator, compiled
from qzs_rig.mechanics.platform import Platform
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.units import DOFS

STANDING = {'platform.A': 1.1, 'platform.k3_hat': 0.2}  # no degree of freedom tips over
SIZE = np.array([0.05, 0.04, 0.2, 0.1])  # m, m, rad, rad: nonlinear, far from instability
TONES = np.array([[9.0, 14.0], [8.0, 15.0], [7.0, 16.0], [6.0, 17.0]])  # rad/s

every_law = pytest.mark.parametrize('law', RESTORING)
every_dof = pytest.mark.parametrize('dof', range(4), ids=DOFS)


def platform(law='closed_form', **given) -> Platform:
    words = {f'platform.{name}': value for name, value in given.items()}
    if law == 'geometric':  # its hinges are stiff: an inertia that keeps tones comparable
        words = {'platform.I_vm': 1.0, 'platform.I_hm': 1.0, **words}
    return Platform.from_spec(scenario.of({**STANDING, 'platform.law': law, **words}))


def base_at(t, size=SIZE):
    """Smooth base motion (n, 12) with its derivatives, two tones a degree of freedom."""
    t = np.asarray(t, dtype=float)[:, None]
    first, second = TONES.T
    x = size * (np.sin(first * t) + 0.5 * np.cos(second * t))
    v = size * (first * np.cos(first * t) - 0.5 * second * np.sin(second * t))
    a = size * (-(first**2) * np.sin(first * t) - 0.5 * second**2 * np.cos(second * t))
    return np.hstack([x, v, a])


def force(rig: Platform, dof: int, w: float) -> float:
    column = np.zeros(4)
    column[dof] = w / rig.length[dof]
    return rig.stiffness[dof] * rig.length[dof] * float(rig.law.force(rig.design, column)[dof])


def integrate(rig, step, base, substeps=1, kernel='auto', chunk=None):
    integrator = Integrator(rig, step, substeps, kernel)
    chunk = chunk or len(base)
    return np.vstack([integrator.push(base[k : k + chunk]) for k in range(0, len(base), chunk)])


@pytest.mark.parametrize('dof', [0, 1], ids=DOFS[:2])
def test_order_is_four(dof):
    rig = platform()
    ends = [
        integrate(rig, 2.0 / n, base_at(np.linspace(0, 2, n + 1)))[-1, dof]
        for n in (1000, 2000, 4000, 8000)
    ]
    coarse, fine, finest = np.abs(np.diff(ends))
    # Richardson: the next term of the error is one order higher, 0.1 at these steps
    assert math.log2(coarse / fine) == pytest.approx(4, abs=0.1)
    assert math.log2(fine / finest) == pytest.approx(4, abs=0.1)


@every_dof
def test_substeps_are_smaller_steps_of_the_same_order(dof):
    rig = platform('linear')
    base = base_at(np.linspace(0, 2, 101))
    ends = [integrate(rig, 0.02, base, substeps)[-1, dof] for substeps in (2, 4, 8, 16)]
    # the input stays the Hermite cubic of the samples, smooth within each of them
    coarse, fine, finest = np.abs(np.diff(ends))
    assert math.log2(fine / finest) == pytest.approx(4, abs=0.1)
    assert coarse > fine > finest


@every_law
@every_dof
def test_energy_in_is_energy_dissipated_and_stored(law, dof):
    rig = platform(law, zeta=0.1)
    n, length = 2**13, 2.0
    base = base_at(np.linspace(0, length, n + 1))
    top = integrate(rig, length / n, base)
    mass, damping = rig.mass[dof], rig.damping[dof]
    u, du, ddu = top[:, dof], top[:, 4 + dof], top[:, 8 + dof]
    w, dw = u - base[:, dof], du - base[:, 4 + dof]
    work = romb(mass * ddu * base[:, 4 + dof], length / n)
    dissipated = romb(damping * dw**2, length / n)
    kinetic = 0.5 * mass * (du[-1] ** 2 - du[0] ** 2)
    potential = quad(lambda x: force(rig, dof, x), w[0], w[-1], epsabs=0, epsrel=1e-12)[0]
    scale = dissipated + abs(kinetic) + abs(potential)
    # RK4 leaves (omega h)^4 / 120 a radian, 1e-10 at 25 rad/s and 0.24 ms, over 50 radians
    assert abs(work - dissipated - kinetic - potential) < 1e-8 * scale


def test_linear_transient_is_the_matrix_exponential():
    rig = platform('linear', zeta=0.1)
    c1, _ = rig.law.cubic(rig.design)[0]
    damping, stiffness = rig.damping[0] / rig.mass[0], c1 * rig.stiffness[0] / rig.mass[0]
    w, h, n = 15.0, 1e-3, 3000
    t = h * np.arange(n + 1)
    base = np.zeros((n + 1, 12))
    base[:, 0], base[:, 4] = 0.03 * np.sin(w * t), 0.03 * w * np.cos(w * t)
    # state: top, its velocity, and the oscillator that drives the base
    system = np.zeros((4, 4))
    system[0, 1], system[2, 3], system[3, 2] = 1, w, -w
    system[1] = [-stiffness, -damping, stiffness, damping * w]
    state = np.array([0.0, 0.03 * w, 0.0, 0.03])
    exact = [expm(system * float(moment)) @ state for moment in t[::500]]
    top = integrate(rig, h, base)[::500, [0, 4]]
    # (omega h)^4 / 120 = 4e-10 a radian over 45 radians; velocities are 15 times larger
    assert np.allclose(top, np.array(exact)[:, :2], rtol=0, atol=2e-8 * 0.03 * w)


@every_dof
def test_linear_steady_state_is_the_textbook_transmissibility(dof):
    c1, _ = RESTORING['linear'].cubic(platform().design)[dof]
    zeta, r, per_cycle = 0.2, 1.3, 256
    rig = platform('linear', zeta=zeta * math.sqrt(c1))
    w = r * rig.omega0[dof] * math.sqrt(c1)
    h = 2 * math.pi / w / per_cycle
    cycles = math.ceil(math.log(1e10) / (2 * math.pi * zeta / r)) + 1  # the transient is gone
    phase = w * h * np.arange(cycles * per_cycle)
    base = np.zeros((len(phase), 12))
    base[:, dof], base[:, 4 + dof] = 0.1 * np.sin(phase), 0.1 * w * np.cos(phase)
    last = integrate(rig, h, base)[-per_cycle:, dof]
    measured = 2j * np.mean(last * np.exp(-1j * phase[-per_cycle:])) / 0.1
    textbook = (1 + 2j * zeta * r) / (1 - r**2 + 2j * zeta * r)
    # the Hermite cubic and RK4 each leave about (omega h)^4 / 384 = 1e-9
    assert measured == pytest.approx(textbook, abs=1e-8)


@every_law
@every_dof
def test_nonlinear_motion_agrees_with_an_independent_solver(law, dof):
    rig = platform(law)
    step, n = 5e-4, 3000
    t = step * np.arange(n + 1)

    def rates(t, state):
        base = base_at([t])[0]
        w, dw = state[0] - base[dof], state[1] - base[4 + dof]
        pull = rig.damping[dof] * dw + force(rig, dof, w)
        return [state[1], -pull / rig.mass[dof]]

    start = base_at([0.0])[0, [dof, 4 + dof]]
    scale = [SIZE[dof], SIZE[dof] * 10]
    reference = solve_ivp(
        rates,
        (0, t[-1]),
        start,
        'DOP853',
        t_eval=t[::100],
        rtol=1e-11,
        atol=[1e-12 * s for s in scale],
    ).y.T
    top = integrate(rig, step, base_at(t))[::100]
    # RK4: (omega h)^4 / 120 a radian, below 1e-9 at 38 rad/s and 0.5 ms, over 57 radians, of a
    # speed that is much higher where the plate falls into a false well
    speed = max(scale[1], np.abs(reference[:, 1]).max())
    assert np.abs(top[:, [dof, 4 + dof]] - reference).max() < 1e-7 * speed


@every_law
def test_acceleration_is_the_force_over_the_mass(law):
    rig = platform(law)
    base = base_at(1e-3 * np.arange(500))
    top = integrate(rig, 1e-3, base)
    w, dw = top[:, :4] - base[:, :4], top[:, 4:8] - base[:, 4:8]
    for dof in range(4):
        pull = [force(rig, dof, x) for x in w[:, dof]]
        expected = -(rig.damping[dof] * dw[:, dof] + pull) / rig.mass[dof]
        # w = u - v is formed from rounded SI values: eps * 0.1 m * stiffness / mass, some times
        size = np.abs(rig.stiffness[dof] * rig.length[dof] / rig.mass[dof])
        assert np.allclose(top[:, 8 + dof], expected, rtol=1e-13, atol=4e-15 * size)


@every_law
@pytest.mark.parametrize('kernel', ['python', 'numba'])
@pytest.mark.parametrize('substeps', [1, 3])
def test_chunks_do_not_change_a_bit(law, kernel, substeps):
    base = base_at(2e-3 * np.arange(601))
    whole = integrate(platform(law), 2e-3, base, substeps, kernel)
    for chunk in (1, 7, 50, 1000):
        cut = integrate(platform(law), 2e-3, base, substeps, kernel, chunk)
        assert cut.tobytes() == whole.tobytes()


@every_law
@pytest.mark.parametrize('substeps', [1, 3])
def test_the_interpreter_and_numba_give_the_same_bits(law, substeps):
    base = base_at(2e-3 * np.arange(1001))
    plain, fast = (
        integrate(platform(law), 2e-3, base, substeps, kernel) for kernel in ('python', 'numba')
    )
    assert plain.tobytes() == fast.tobytes()


@every_law
@every_dof
def test_degrees_of_freedom_move_by_themselves(law, dof):
    rig = platform(law)
    base = base_at(2e-3 * np.arange(300))
    alone = np.zeros_like(base)
    columns = [dof, 4 + dof, 8 + dof]
    alone[:, columns] = base[:, columns]
    top, single = integrate(rig, 2e-3, base), integrate(rig, 2e-3, alone)
    assert np.array_equal(single[:, columns], top[:, columns])


def test_a_base_at_rest_leaves_the_top_at_rest():
    for chunk in (1, 50, 200):
        assert not integrate(platform('symmetric'), 1e-3, np.zeros((200, 12)), chunk=chunk).any()


def test_the_top_starts_riding_on_the_base():
    base = base_at(1e-3 * np.arange(3))
    top = integrate(platform(), 1e-3, base)
    assert np.allclose(top[0, :8], base[0, :8], rtol=1e-15)


@every_law
@pytest.mark.parametrize('kernel', ['python', 'numba'])
@pytest.mark.parametrize('trim', [-10.0, 10.0])
def test_a_trimmed_platform_stays_where_it_rests(law, kernel, trim):
    rig = platform(law, payload_trim=trim)
    top = integrate(rig, 1e-3, np.zeros((500, 12)), kernel=kernel)
    # the rest position is found to the last bits of terms of order 1
    assert np.allclose(top[:, 0], rig.rest[0] * rig.length[0], rtol=0, atol=1e-13)
    assert np.abs(top[:, 8]).max() < 1e-11


def test_a_trimmed_platform_swings_about_its_rest_at_the_frequency_of_the_stiffness_there():
    rig = platform('corrected', payload_trim=10.0, zeta=0.0)
    step, n = 1e-3, 4000
    base = np.zeros((n, 12))
    base[1:, 0] = 1e-6  # a step of the base sets off a small swing
    swing = integrate(rig, step, base)[1:, 0] - 1e-6 - rig.rest[0] * rig.length[0]
    crossings = np.flatnonzero(np.diff(np.signbit(swing)))
    half = np.diff(crossings).mean() * step
    expected = rig.omega0[0] * math.sqrt(rig.cubic[0][0])
    # each crossing is known to a step
    assert math.pi / half == pytest.approx(expected, rel=2 / (crossings[-1] - crossings[0]))


def test_no_samples_give_no_samples():
    integrator = Integrator(platform(), 1e-3, 1, 'python')
    assert integrator.push(np.empty((0, 12))).shape == (0, 12)


def run_away(dof):
    """Base motion that throws `dof` out of the law: a plate past 1 rad, a softening spring."""
    t = 2e-3 * np.arange(2000)
    base = np.zeros((len(t), 12))
    size, w = {'horizontal_rotation': (3.0, 30.0), 'vertical_rotation': (20.0, 6.0)}[dof]
    column = DOFS.index(dof)
    base[:, column] = size * 0.5 * (1 - np.cos(w * t))
    base[:, 4 + column] = size * 0.5 * w * np.sin(w * t)
    return base


@pytest.mark.parametrize('chunk', [1, 7, 2000])
@pytest.mark.parametrize('kernel', ['python', 'numba'])
@pytest.mark.parametrize(
    ('law', 'dof'), [('corrected', 'horizontal_rotation'), ('symmetric', 'vertical_rotation')]
)
def test_divergence_names_the_motion_and_the_last_good_sample(law, dof, kernel, chunk):
    rig, base, column = platform(law), run_away(dof), DOFS.index(dof)
    integrator = Integrator(rig, 2e-3, 1, kernel)
    good = []
    with pytest.raises(DivergenceError, match=f'{dof} left the domain of law {law}') as caught:
        for k in range(0, len(base), chunk):
            good.append(integrator.push(base[k : k + chunk]))
    last = caught.value.last_good_sample
    assert f'after sample {last} ({last * 2e-3:.3f} s)' in str(caught.value)
    assert 'lower excitation.amplitude' in str(caught.value)
    assert np.isfinite(np.vstack([*good, np.zeros((1, 12))])).all()
    # an independent bound: up to that sample a fresh integrator has no complaint, then it has
    assert np.isfinite(integrate(rig, 2e-3, base[: last + 1])[:, column]).all()
    with pytest.raises(DivergenceError, match=f'after sample {last} '):
        integrate(rig, 2e-3, base[: last + 2])


@pytest.mark.parametrize('kernel', ['python', 'numba'])
def test_a_base_that_is_not_finite_is_a_divergence(kernel):
    base = base_at(1e-3 * np.arange(20))
    base[10:, 0] = np.nan
    with pytest.raises(DivergenceError, match=r'vertical left .* after sample 9 ') as caught:
        integrate(platform(), 1e-3, base, 3, kernel)
    assert caught.value.last_good_sample == 9


def test_numba_must_be_there_when_it_is_asked_for(monkeypatch):
    base = base_at(1e-3 * np.arange(50))
    fast = integrate(platform(), 1e-3, base, kernel='numba')
    compiled.cache_clear()
    monkeypatch.setitem(sys.modules, 'numba', None)
    with pytest.raises(InputError, match=r"platform.kernel = 'numba' needs numba; pip install"):
        Integrator(platform(), 1e-3, 1, 'numba')
    assert integrate(platform(), 1e-3, base, kernel='auto').tobytes() == fast.tobytes()
