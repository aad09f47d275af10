"""Six coordinates balanced, against the plant's own integrated motion."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from qzs_rig import scenario
from qzs_rig.mechanics import rigid_body
from qzs_rig.mechanics.coupled_integrator import base_rows, body
from qzs_rig.mechanics.geometry import Geometry
from qzs_rig.theory.balance import newton
from qzs_rig.theory.balance.coupled_response import CoupledBalance, coupled_response
from qzs_rig.theory.balance.frequency_response import frequency_response
from qzs_rig.theory.balance.plate import Plate
from qzs_rig.theory.oscillator import Oscillator

DOFS = ('vertical', 'horizontal', 'vertical_rotation', 'horizontal_rotation')
SPEC = scenario.of(
    {'platform.law': 'geometric', 'platform.zeta': 0.1, 'platform.cm_height': 0.03,
     'platform.I_hm': 1.0, 'platform.I_vm': 2.0}
)  # fmt: skip
GEOMETRY = Geometry.from_spec(SPEC)


def found_motion(dof, omega, harmonics=11):
    """A converged motion at `omega`, from a plate at rest in space."""
    balance = CoupledBalance(Plate(GEOMETRY, dof, 0.03), harmonics)
    x = newton.solve(balance, balance.resting(), math.log(omega))
    assert x is not None
    return balance, x


def integrated(balance, x, omega):
    """SI state (13,) of the plant before and after one period of the base."""
    start = plant_state(balance, x, omega)
    return start, after_a_period(balance.plate, omega, start)


def plant_state(balance, x, omega):
    g = balance.plate.geometry
    rate = math.sqrt(g.k1 / g.mass)
    q, dq, _ = (part[:, 0] for part in balance.motion(x, omega, np.zeros(1)))
    w = math.sqrt(1 - q[3:] @ q[3:])
    dw = -(q[3:] @ dq[3:]) / w
    vector, speed = q[3:], dq[3:]
    spin = 2 * (w * speed - vector * dw - np.cross(vector, speed))
    return np.concatenate([q[:3] * g.L20, dq[:3] * g.L20 * rate, [w], vector, spin * rate])


def after_a_period(plate, omega, start):
    g = plate.geometry
    rate = math.sqrt(g.k1 / g.mass)
    index = DOFS.index(plate.dof)
    size = plate.base(omega) * (g.L20 if index < 2 else 1.0)

    def rates(t, y):
        base = np.zeros((1, 8))
        base[0, index] = size * math.cos(omega * rate * t)
        base[0, 4 + index] = -size * omega * rate * math.sin(omega * rate * t)
        return rigid_body.rates(math.sqrt, g.springs, body(g), base_rows(base)[0], y)

    end = 2 * np.pi / (omega * rate)
    return solve_ivp(rates, (0, end), start, 'DOP853', [end], rtol=1e-10, atol=1e-12).y[:, -1]


def flow_multipliers(balance, x, omega):
    """Of the plant itself, by central differences of its flow; largest first."""
    start = plant_state(balance, x, omega)
    free = [*range(6), *range(7, 13)]  # the quaternion's real part follows from the others
    columns = []
    for place in free:
        ends = []
        for h in (1e-5, -1e-5):
            moved = np.array(start)
            moved[place] += h
            moved[6] = math.sqrt(1 - moved[7:10] @ moved[7:10])
            ends.append(after_a_period(balance.plate, omega, moved)[free])
        columns.append((ends[0] - ends[1]) / 2e-5)
    found = np.linalg.eigvals(np.stack(columns, axis=1))
    return found[np.argsort(-np.abs(found))]


@pytest.mark.parametrize('dof', DOFS)
def test_balanced_motions_repeat_in_the_plant(dof):
    balance, x = found_motion(dof, 2.2)
    start, end = integrated(balance, x, 2.2)
    # eleven harmonics of a smooth motion; the issue asks for 1e-6
    np.testing.assert_allclose(end, start, atol=1e-6 * max(1.0, np.abs(start).max()))


def test_slopes_of_the_balance():
    balance = CoupledBalance(Plate(GEOMETRY, 'horizontal_rotation', 0.05), 2)
    x = balance.resting() + 0.02 * np.random.default_rng(0).normal(size=30)
    _, jacobian, slope = balance.linearised(x, 0.1)
    h = 1e-6
    omega = math.exp(0.1)
    columns = [
        (balance.residual(x + h * v, omega) - balance.residual(x - h * v, omega)) / (2 * h)
        for v in np.eye(30)
    ]
    np.testing.assert_allclose(jacobian, np.stack(columns, axis=1), atol=1e-6)
    ahead, behind = (balance.residual(x, math.exp(0.1 + side)) for side in (h, -h))
    np.testing.assert_allclose(slope, (ahead - behind) / (2 * h), atol=1e-6)


def test_multipliers_shrink_as_damping_says():
    """Liouville: their product is exp of the integrated divergence, of the dampers alone."""
    balance, x = found_motion('vertical', 2.2)
    found = balance.multipliers(balance.full(x), 2.2)
    g = balance.plate.scaled
    cz, cxy, cyaw, ctilt = g.damping
    # translation and rotation share `height`: the trace of M^-1 C
    lever = 2 * cxy * g.height**2 / g.inertia_xy
    divergence = cz + 2 * cxy + cyaw / g.inertia_z + 2 * ctilt / g.inertia_xy + lever
    assert np.log(np.abs(np.prod(found))) == pytest.approx(-divergence * 2 * np.pi / 2.2, rel=1e-6)


def test_vertical_motion_stays_on_its_axis():
    own = Oscillator.of(SPEC, 'vertical', 0.1)
    alone = frequency_response(own, 0.6, 2.5)
    found = coupled_response(GEOMETRY, own, 0.6, 2.5)
    assert len(found.branches) == len(alone.branches)
    for six, one in zip(found.branches, alone.branches, strict=True):
        np.testing.assert_array_equal(six.T, one.T)
        assert six.multipliers.shape == (len(one.omega), 12)
        # what one degree of freedom loses, six lose too
        assert not np.any(six.stable & ~one.stable)
        single = np.abs(one.multipliers).max(axis=1)
        nearest = np.abs(np.abs(six.multipliers) - single[:, None]).min(axis=1)
        assert nearest.max() < 1e-5


def test_small_horizontal_motion_is_the_linear_one():
    own = Oscillator.of(SPEC, 'horizontal', 1e-5)
    found = coupled_response(GEOMETRY, own, 2.0, 2.5)
    (branch,) = found.branches
    assert branch.stable.all()
    balance = CoupledBalance(Plate(GEOMETRY, 'horizontal', 1e-5), 1)
    k = len(branch.omega) // 2
    omega = float(branch.omega[k])
    x = newton.solve(balance, balance.resting(), math.log(omega))
    top = balance.seen(x)
    # nonlinear terms are of the square of 1e-5
    assert branch.T[k] == pytest.approx(math.hypot(top[1], top[2]) / 1e-5, rel=1e-6)
    assert found.reason is None


def test_multipliers_are_those_of_the_plant():
    balance, x = found_motion('horizontal_rotation', 2.2, 7)
    expected = flow_multipliers(balance, x, 2.2)
    # central differences of 1e-5 on a flow integrated to 1e-10
    found = balance.multipliers(balance.full(x), 2.2)
    np.testing.assert_allclose(np.abs(found), np.abs(expected), atol=1e-4)


def test_parametric_instability_is_found_and_located():
    """A payload above the plate: vertical motion throws it sideways, at twice the period."""
    spec = scenario.of(
        {'platform.law': 'geometric', 'platform.zeta': 0.01, 'platform.cm_height': 0.1,
         'platform.I_hm': 1.0, 'platform.I_vm': 2.0}
    )  # fmt: skip
    own, geometry = Oscillator.of(spec, 'vertical', 0.4), Geometry.from_spec(spec)
    alone = frequency_response(own, 1.72, 1.80, isolas=False)
    found = coupled_response(geometry, own, 1.72, 1.80)
    (event,) = [e for e in found.events if e.kind == 'period_doubling']
    for branch, one in zip(found.branches, alone.branches, strict=True):
        if one.stable.all():
            assert not branch.stable[branch.omega < event.omega - 1e-6].any()
            assert branch.stable[branch.omega > event.omega + 1e-6].all()
    balance = CoupledBalance(Plate(geometry, 'vertical', 0.4), 15)
    x = newton.solve(balance, balance.resting(), math.log(event.omega))
    lead = flow_multipliers(balance, x, event.omega)[0]
    # central differences, as above
    assert lead == pytest.approx(-1.0, abs=1e-4)
    assert balance.multipliers(balance.full(x), event.omega)[0] == pytest.approx(-1.0, abs=1e-7)
