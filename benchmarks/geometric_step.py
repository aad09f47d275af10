"""Time of one coupled step (six degrees of freedom, four evaluations of the wrench), interpreter
against numba and against the four uncoupled degrees of freedom; budget 50 us."""

from __future__ import annotations

import statistics
import time

import numpy as np

from qzs_rig import scenario
from qzs_rig.mechanics.coupled_integrator import CoupledIntegrator
from qzs_rig.mechanics.geometry import Geometry
from qzs_rig.mechanics.integrator import Integrator
from qzs_rig.mechanics.platform import Platform

STEP = 2e-3
SAMPLES = 2000
REPEATS = 15
BUDGET_US = 50.0


def main() -> None:
    """Print medians over chunks, the whole `push` included."""
    print(f'{"":44}{"us a step":>12}{"ratio":>9}')
    single = _time(lambda: Integrator(_platform('corrected'), STEP, 1, 'python'), _base(True))
    print(f'{"four uncoupled, interpreter":44}{single:12.2f}{1.0:9.2f}')
    for kernel in ('python', 'numba'):
        for turning in (False, True):
            got = _time(lambda: CoupledIntegrator(_geometry(), STEP, 1, kernel), _base(turning))  # noqa: B023
            name = f'six coupled, {kernel}, base {"turning" if turning else "level"}'
            verdict = '' if got <= BUDGET_US else '  over budget'
            print(f'{name:44}{got:12.2f}{got / single:9.2f}{verdict}')


def _platform(law: str) -> Platform:
    return Platform.from_spec(scenario.of({'platform.law': law, 'platform.L0_hat': 0.08}))


def _geometry() -> Geometry:
    return Geometry.from_spec(scenario.of({'platform.law': 'geometric', 'platform.cm_height': 0.1}))


def _base(turning: bool) -> np.ndarray:
    t = STEP * np.arange(SAMPLES)[:, None]
    size, w = np.array([0.02, 0.02, 0.05, 0.05]), np.array([9.0, 10.0, 11.0, 12.0])
    if not turning:
        size = size * [1, 1, 0, 0]
    return np.hstack([size * np.sin(w * t), size * w * np.cos(w * t)])


def _time(make, base: np.ndarray) -> float:
    integrator = make()
    integrator.push(base)
    times = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        integrator.push(base)
        times.append((time.perf_counter() - began) / len(base) * 1e6)
    return statistics.median(times)


if __name__ == '__main__':
    main()
