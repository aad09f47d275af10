"""Speed of `qzs-rig run`, interpreter against numba, recorded or not, and a peer: the same base
motion through scipy's general-purpose integrator, the usual way to do this in a script."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline

from qzs_rig import scenario
from qzs_rig.cli.run import Recorder, sheet_of
from qzs_rig.mechanics.platform import Platform
from qzs_rig.parameters import RunSpec
from qzs_rig.run import in_process
from qzs_rig.run.stages import ExciterStage
from qzs_rig.samples import NS

REPEATS = 3
PEER_S = 20.0


def main() -> None:
    """Print rig seconds a wall second; the best of a few repeats."""
    spec = scenario.load(scenario.DEFAULT)
    peer = _peer(spec)
    print(f'{"":34}{"x real time":>12}{"ratio":>9}')
    print(f'{"scipy solve_ivp RK45, plant only":34}{peer:12.1f}{1.0:9.1f}')
    for kernel in ('python', 'numba'):
        for recorded in (True, False):
            speed = max(_speed(spec.override({'platform.kernel': kernel}), recorded)
                        for _ in range(REPEATS))  # fmt: skip
            name = f'qzs-rig run, {kernel}, {"bag" if recorded else "no bag"}'
            print(f'{name:34}{speed:12.1f}{speed / peer:9.1f}')


def _speed(spec: RunSpec, recorded: bool) -> float:
    if not recorded:
        result = in_process.run(spec)
        return result.rig_s / result.wall_s
    with tempfile.TemporaryDirectory() as scratch:
        exciter = ExciterStage(spec, scenario.step_ns_of(spec))
        sheet = sheet_of(spec, exciter.samples, scenario.DEFAULT, 'benchmark')
        recorder = Recorder(Path(scratch) / 'bag', spec, sheet)
        began = time.perf_counter()
        result = in_process.run(spec, sheet.start_ns, tap=recorder.keep, exciter=exciter)
        recorder.close(sheet)
        return result.rig_s / (time.perf_counter() - began)


def _peer(spec: RunSpec) -> float:
    """One degree of freedom of the same platform by solve_ivp, at 1e-6."""
    step_ns = scenario.step_ns_of(spec)
    base = ExciterStage(spec, step_ns).take(round(PEER_S * NS / step_ns)).data
    platform = Platform.from_spec(spec)
    t = np.arange(len(base)) * step_ns / NS
    motion = CubicHermiteSpline(t, base[:, 0], base[:, 4])
    speed = motion.derivative()
    c, s = (x[0] / platform.mass[0] for x in (platform.damping, platform.stiffness))
    length, formula = platform.length[0], platform.law.along(0)

    def rate(now: float, state: np.ndarray) -> list[float]:
        u, du = state
        pull = length * formula(platform.design, (u - motion(now)) / length)
        return [du, float(-c * (du - speed(now)) - s * pull)]

    began = time.perf_counter()
    solve_ivp(rate, (0.0, t[-1]), [0.0, 0.0], t_eval=t, rtol=1e-6, atol=1e-9)
    return PEER_S / (time.perf_counter() - began)


if __name__ == '__main__':
    main()
