"""How often the 95 % intervals of `qzs-rig identify` hold the truth: 100 seeded trials a case.

Every trial draws its own platform, is stepped up and down through the jump by the Runge-Kutta of
test/identification/measured_platform.py (nothing of the product), gets noise that differs from
point to point, and is fitted from the same start. Prints trials inside for each parameter.

    python benchmarks/identify_coverage.py [trials [case]]
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / 'test' / 'identification'))

from measured_platform import stepped

from qzs_rig import scenario
from qzs_rig.identification.identify import identify
from qzs_rig.identification.points import Points
from qzs_rig.identification.unknowns import DEFAULT

CASES = ('with std', 'without std', 'without phase')
N = 20
NOISE = 0.01


def main() -> None:
    """Measure, fit, count."""
    trials = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    rng = np.random.default_rng(4)
    truth = np.stack(
        [
            rng.uniform(0.03, 0.08, trials),
            rng.uniform(1.08, 1.12, trials),
            rng.uniform(-1, 1, trials),
        ]
    )
    up = np.geomspace(1.0, 4.0, N)
    began = time.perf_counter()
    hz = np.concatenate([up, up[::-1]])
    ratio = stepped(hz, *truth, settle_s=25.0)
    print(f'{trials} platforms measured in {time.perf_counter() - began:.0f} s')
    spec = scenario.load('vertical_sweep')
    for case in sys.argv[2:] or CASES:
        began, inside, width = time.perf_counter(), np.zeros(len(DEFAULT), int), []
        for k in range(trials):
            points = noisy(hz, ratio[:, k], np.random.default_rng((7, k)), case)
            found = identify(spec, [points], DEFAULT)
            held = [i.low <= t <= i.high for i, t in zip(found.intervals, truth[:, k], strict=True)]
            inside += held
            width.append([i.high - i.low for i in found.intervals])
            if not all(held):
                told = [(f'{i.low:.5g}', f'{i.high:.5g}') for i in found.intervals]
                print(f'  {case}, trial {k}: truth {truth[:, k].round(5)}, intervals {told}')
        seconds = (time.perf_counter() - began) / trials
        for name, count, middle in zip(DEFAULT, inside, np.median(width, axis=0), strict=True):
            print(f'{case:14} {name:22} {count}/{trials} inside, median width {middle:.3g}')
        print(f'{case:14} {seconds:.2f} s a fit', flush=True)


def noisy(hz: np.ndarray, ratio: np.ndarray, rng: np.random.Generator, case: str) -> Points:
    """The curve with relative noise of half to twice NOISE, another at each point."""
    n = len(hz)
    sigma = NOISE * rng.uniform(0.5, 2.0, n)
    T = np.abs(ratio)
    return Points(
        'vertical',
        np.where(np.arange(n) < N, 'forward', 'reverse'),
        hz,
        T * (1.0 + sigma * rng.standard_normal(n)),
        np.full(n, np.nan)
        if case == 'without phase'
        else np.angle(ratio) + sigma * rng.standard_normal(n),
        sigma * T if case == 'with std' else np.full(n, np.nan),
        np.zeros(n),
    )


if __name__ == '__main__':
    main()
