"""Bifurcation diagram of Figure 13: 1000 damping ratios x 500 periods, the last 400 kept, closed
form, vertical, H = 0.6, Omega = 6.28/20, against heyoka's batch mode at equal error and against
vectorised numpy RK4 with the paper's thousandth of a period. `--campaign`: a million runs.

Without heyoka (`make peers` installs it) its rows are left out. The peers run on a part of the
work, scaled up; the table says which.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from importlib.util import find_spec

import numpy as np
from scipy.integrate import solve_ivp

from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import PAPER_DESIGN
from qzs_rig.samples import Array
from qzs_rig.theory.motion.batch import Batch
from qzs_rig.theory.motion.stroboscope import Stroboscope, strobe, strobe_within
from qzs_rig.theory.oscillator import Oscillator

RUNS, PERIODS, KEEP = 1000, 500, 400
OMEGA, AMPLITUDE = 6.28 / 20.0, 0.6
STEPS = 18
ZETA = np.linspace(0.0158, 0.158, RUNS)
PEER = np.linspace(0, RUNS - 1, 40).astype(int)
"""Runs that the peers and the reference do."""
PEER_PERIODS = 100


def system() -> Oscillator:
    """Figure 13, vertical."""
    return Oscillator(RESTORING['closed_form'], 'vertical', PAPER_DESIGN, 0.07, AMPLITUDE)


def best(
    work: Callable[[], object], repeats: int, clock: Callable[[], float] = time.process_time
) -> float:
    """Shortest of some repeats in s: what disturbs a measurement makes it longer. One thread is
    timed by the processor's seconds, which a busy machine does not stretch; two by the clock."""
    times = []
    for _ in range(repeats):
        began = clock()
        work()
        times.append(clock() - began)
    return min(times)


def reference(periods: int) -> Array:
    """(len(PEER), periods) w once a period by DOP853 at its tightest."""
    own = system()

    def rates(t: float, y: Array, zeta: float) -> list[float]:
        push = own.drive(OMEGA) * np.cos(OMEGA * t)
        return [y[1], push - 2.0 * zeta * y[1] - float(own.force(y[0]))]

    flashes = 2.0 * np.pi / OMEGA * np.arange(1, periods + 1)
    return np.array(
        [
            solve_ivp(
                rates,
                (0.0, flashes[-1]),
                [0.0, 0.0],
                'DOP853',
                t_eval=flashes,
                rtol=1e-13,
                atol=1e-14,
                args=(zeta,),
            ).y[0]
            for zeta in ZETA[PEER]
        ]
    )


def heyoka_batch(tolerance: float, width: int) -> Callable[[], Array]:
    """heyoka over the PEER runs, `width` at a time; gives w (len(PEER), PEER_PERIODS)."""
    import heyoka as hy

    A, k3, L1, _, a, b = PAPER_DESIGN
    x, v = hy.make_vars('x', 'v')
    zeta = hy.par[0]
    length = hy.sqrt(x * x + a * a)
    force = x + A * x * (1.0 - 1.0 / length) + k3 * (a / length) * (x + L1) - b
    push = AMPLITUDE * OMEGA**2 * hy.cos(OMEGA * hy.time)
    integrator = hy.taylor_adaptive_batch(
        [(x, v), (v, push - 2.0 * zeta * v - force)],
        np.zeros((2, width)),
        pars=np.zeros((1, width)),
        tol=tolerance,
    )
    flashes = 2.0 * np.pi / OMEGA * np.arange(PEER_PERIODS + 1)

    def work() -> Array:
        points = []
        for first in range(0, len(PEER), width):
            integrator.set_time(0.0)
            integrator.state[:] = 0.0
            integrator.pars[0] = ZETA[PEER[first : first + width]]
            grid = np.repeat(flashes[:, None], width, axis=1)
            points.append(integrator.propagate_grid(grid)[1][1:, 0].T)
        return np.concatenate(points)

    return work


def runge_kutta(steps: int, periods: int, zeta: Array) -> Array:
    """Classical RK4 in numpy over all of `zeta` at once; w once a period (n, periods)."""
    own = system()
    h, drive = 2.0 * np.pi / OMEGA / steps, own.drive(OMEGA)
    w, v = np.zeros_like(zeta), np.zeros_like(zeta)
    points = np.empty((len(zeta), periods))

    def rate(t: float, w: Array, v: Array) -> Array:
        return drive * np.cos(OMEGA * t) - 2.0 * zeta * v - own.force(w)

    for k in range(periods * steps):
        t = k * h
        a1 = rate(t, w, v)
        v2 = v + 0.5 * h * a1
        a2 = rate(t + 0.5 * h, w + 0.5 * h * v, v2)
        v3 = v + 0.5 * h * a2
        a3 = rate(t + 0.5 * h, w + 0.5 * h * v2, v3)
        v4 = v + h * a3
        a4 = rate(t + h, w + h * v3, v4)
        w = w + h / 6.0 * (v + 2.0 * (v2 + v3) + v4)
        v = v + h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)
        if (k + 1) % steps == 0:
            points[:, k // steps] = w
    return points


def diagram() -> None:
    """The table of the diagram."""
    runs = Batch.of(system(), OMEGA, zeta=ZETA)
    exact = strobe(runs, steps=256, periods=PERIODS, keep=KEEP, early=False)
    # two independent methods at their tightest: DOP853 says how far the fine steps can be trusted
    slow = reference(PEER_PERIODS)
    fine = strobe(runs[PEER], steps=256, periods=PEER_PERIODS, keep=PEER_PERIODS, early=False)
    print('reference: 256 steps a period; it differs from DOP853 (rtol 1e-13) by')
    print(f'{np.abs(fine.w - slow).max():.1e} over {PEER_PERIODS} periods of {len(PEER)} runs\n')
    print(f'{"1000 zeta x 500 periods":58}{"s":>9}{"ratio":>9}{"max error":>11}{"over 1e-6":>10}')
    fixed = {'steps': STEPS, 'periods': PERIODS, 'keep': KEEP}
    checked = {'periods': PERIODS, 'keep': KEEP}
    rows: list[tuple[str, Callable[[], Stroboscope]]] = []
    for workers in (1, 2):
        core = f'{workers} thread{"s" if workers > 1 else ""}'
        rows += [
            (
                f'{STEPS} steps, every period, {core}',
                lambda w=workers: strobe(runs, early=False, workers=w, **fixed),
            ),
            (
                f'{STEPS} steps, early exit, {core}',
                lambda w=workers: strobe(runs, workers=w, **fixed),
            ),
            (
                f'each run checked to 1e-6, every period, {core}',
                lambda w=workers: strobe_within(runs, early=False, workers=w, **checked),
            ),
            (
                f'each run checked to 1e-6, early exit, {core}',
                lambda w=workers: strobe_within(runs, workers=w, **checked),
            ),
        ]
    ours = 0.0
    for name, work in rows:
        off = np.abs(work().w - exact.w).max(axis=1)
        clock = time.perf_counter if '2 threads' in name else time.process_time
        took = best(work, 9, clock)
        ours = ours or took
        over = int(np.count_nonzero(off > 1e-6))
        print(f'{name:58}{took:9.4f}{took / ours:9.2f}{off.max():11.1e}{over:10d}')
    own = strobe(runs[PEER], steps=STEPS, periods=PEER_PERIODS, keep=PEER_PERIODS, early=False)
    mine = np.abs(own.w - slow).max(axis=1)
    print(f"\nours on the peers' part: median error {np.median(mine):.1e}, max {mine.max():.1e}")
    print(f'{"peers, one thread, scaled up":58}{"s":>9}{"ratio":>9}{"median":>11}{"max":>10}')
    scale = RUNS / len(PEER) * PERIODS / PEER_PERIODS
    if not find_spec('heyoka'):
        print(f'{"heyoka batch of 8":58}not installed: make peers')
    for tolerance in (1e-5, 1e-6, 1e-7, 1e-8, 1e-9) if find_spec('heyoka') else ():
        work = heyoka_batch(tolerance, 8)
        off = np.abs(work() - slow).max(axis=1)
        took = best(work, 2) * scale
        name = f'heyoka batch of 8, tol {tolerance:g}'
        print(f'{name:58}{took:9.2f}{took / ours:9.1f}{np.median(off):11.1e}{off.max():10.1e}')
    periods = 2
    took = best(lambda: runge_kutta(1000, periods, ZETA), 1) * PERIODS / periods
    off = np.abs(runge_kutta(1000, periods, ZETA[PEER]) - slow[:, :periods]).max(axis=1)
    name = f'numpy RK4, T/1000, all runs at once ({periods} periods)'
    print(f'{name:58}{took:9.2f}{took / ours:9.0f}{np.median(off):11.1e}{off.max():10.1e}')


def campaign() -> None:
    """A million runs over damping, amplitude and frequency: figures only, memory bounded."""
    n, rng = 1_000_000, np.random.default_rng(0)
    runs = Batch.of(
        system(),
        rng.uniform(0.3, 1.5, n),
        zeta=rng.uniform(0.0158, 0.158, n),
        amplitude=rng.uniform(0.05, 0.6, n),
    )
    title = 'a million runs x 500 periods, figures only, 2 threads'
    print(f'\n{title:58}{"s":>9}{"cpu s/2":>9}{"settled":>9}')
    for steps in (12, 18):
        for early in (True, False):
            began, busy = time.perf_counter(), time.process_time()
            seen = strobe(runs, steps=steps, periods=PERIODS, keep=0, early=early, workers=2)
            took, used = time.perf_counter() - began, time.process_time() - busy
            name = f'{steps} steps, {"early exit" if early else "every period"}'
            settled = np.mean(seen.period > 0)
            print(f'{name:58}{took:9.2f}{used / 2.0:9.2f}{settled:9.1%}', flush=True)
        some = slice(0, n, 500)
        off = np.abs(
            strobe(runs[some], steps=4 * steps, periods=20, keep=20, early=False).w
            - strobe(runs[some], steps=steps, periods=20, keep=20, early=False).w
        ).max(axis=1)
        print(f'  error of w in 20 periods: median {np.median(off):.1e}, ', end='')
        print(f'90 % of runs below {np.quantile(off, 0.9):.1e}')


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--campaign', action='store_true', help='also a million runs')
    options = parser.parse_args()
    print(f'{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}')
    began = time.perf_counter()
    strobe(Batch.of(system(), OMEGA, zeta=ZETA[:64]), steps=STEPS, periods=20, keep=10)
    print(f'first result after {time.perf_counter() - began:.2f} s (compiled, or read from disk)')
    diagram()
    if options.campaign:
        campaign()


if __name__ == '__main__':
    main()
