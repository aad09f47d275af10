"""What one sample of the four-degree-of-freedom platform costs, beside two named peers, in one run.

All get the same platform (Table 1, law closed_form, k3_hat = 0.2 so that nothing tips over) and the
same base motion, two tones a degree of freedom at 500 Hz. Peers: a numpy Runge-Kutta 4 over the
four degrees of freedom at once, with the exact base motion, as one would write it first; and
scipy's solve_ivp (RK45), at the loosest relative tolerance whose error is not above the rig's, with
output at every sample. Errors are the largest against DOP853 at 1e-12, over the motion's amplitude.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

from qzs_rig import scenario
from qzs_rig.mechanics.integrator import Integrator
from qzs_rig.mechanics.platform import Platform

STEP, SAMPLES, REPEATS = 2e-3, 2001, 7
T = STEP * np.arange(SAMPLES)
SIZE = np.array([0.05, 0.04, 0.2, 0.1])  # m, m, rad, rad
SLOW, FAST = np.array([[9.0, 8.0, 7.0, 6.0], [14.0, 15.0, 16.0, 17.0]])  # rad/s

RIG = Platform.from_spec(scenario.of({'platform.law': 'closed_form', 'platform.k3_hat': 0.2}))
MASS, DAMPING, LENGTH = (np.array(v) for v in (RIG.mass, RIG.damping, RIG.length))
STIFFNESS = np.array(RIG.stiffness) * LENGTH


def base_at(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Position and velocity of the base at t (...,) -> (..., 4) each."""
    slow, fast = SLOW * t[..., None], FAST * t[..., None]
    position = SIZE * (np.sin(slow) + 0.5 * np.cos(fast))
    return position, SIZE * (SLOW * np.cos(slow) - 0.5 * FAST * np.sin(fast))


def rates(t: float, state: np.ndarray) -> np.ndarray:
    """Time derivative of the top's position and velocity (8,)."""
    position, velocity = base_at(np.asarray(t))
    force = STIFFNESS * RIG.law.force(RIG.design, (state[:4] - position) / LENGTH)
    pull = DAMPING * (state[4:] - velocity) + force
    return np.concatenate([state[4:], -pull / MASS])


def by_rig(kernel: str) -> np.ndarray:
    return Integrator(RIG, STEP, 1, kernel).push(np.hstack(base_at(T)))[:, :4]


def by_numpy() -> np.ndarray:
    state = np.concatenate(base_at(T[0]))
    top = [state[:4]]
    for t in T[:-1].tolist():
        k1 = rates(t, state)
        k2 = rates(t + 0.5 * STEP, state + 0.5 * STEP * k1)
        k3 = rates(t + 0.5 * STEP, state + 0.5 * STEP * k2)
        k4 = rates(t + STEP, state + STEP * k3)
        state = state + STEP / 6 * (k1 + 2 * (k2 + k3) + k4)
        top.append(state[:4])
    return np.array(top)


def by_scipy(method: str, rtol: float) -> np.ndarray:
    start = np.concatenate(base_at(T[0]))
    answer = solve_ivp(rates, (0, T[-1]), start, method, t_eval=T, rtol=rtol, atol=1e-3 * rtol)
    return np.asarray(answer.y[:4].T)


def cost(work: Callable[[], object], repeats: int) -> float:
    """Median of `repeats`, microseconds a sample; the first call, which may compile, is not
    counted."""
    work()
    seconds = []
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - begin)
    return statistics.median(seconds) / SAMPLES * 1e6


def main() -> None:
    reference = by_scipy('DOP853', 1e-12)

    def error(top: np.ndarray) -> float:
        return float(np.abs((top - reference) / SIZE).max())

    rig_error = error(by_rig('python'))
    tolerances = 10.0 ** -np.arange(3.0, 12.0, 0.5)
    rtol = next(r for r in tolerances if error(by_scipy('RK45', r)) <= rig_error)
    rows: list[tuple[str, Callable[[], np.ndarray], int]] = [
        ('rig, numba kernel', lambda: by_rig('numba'), REPEATS),
        ('rig, python kernel', lambda: by_rig('python'), REPEATS),
        ('numpy RK4, 4-vectors', by_numpy, 3),
        (f'scipy solve_ivp RK45, rtol {rtol:.0e}', lambda: by_scipy('RK45', rtol), 3),
    ]
    costs = {name: cost(work, repeats) for name, work, repeats in rows}
    numba = costs['rig, numba kernel']
    print(f'{"":36} us a sample | / numba | error over amplitude')
    for name, work, _ in rows:
        print(f'{name:36} {costs[name]:11.2f} | {costs[name] / numba:7.1f} | {error(work()):.1e}')


if __name__ == '__main__':
    main()
