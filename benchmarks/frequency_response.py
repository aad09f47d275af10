"""What a frequency response costs, beside harmonic balances from PyPI.

    python benchmarks/frequency_response.py [--harmonics 7] [--repeats 20]

One oscillator, x'' + 0.05 x' + x + 0.1 x³ = 0.18 cos Ωt (NLvib's example 01, two folds), Ω from 2
down to 0.5, the same number of harmonics, one process, one core, best of the repeats. Ours is the
whole curve through both folds with Floquet multipliers. harmonicbalance continues by arc length
too, over as many points, without stability. mousai knows no continuation: it solves at as many
fixed frequencies, each from the motion before it, and jumps at a fold where we go round; its
points are those that converged, to its own tolerance of 6e-6. skhippr is named for completeness.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import math
import time
from collections.abc import Callable

import numpy as np

from qzs_rig import scenario
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import PAPER_DESIGN, RestoringLaw
from qzs_rig.theory.balance.frequency_response import Branch, frequency_response, least_branch
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import DOFS

LOW, HIGH = 0.5, 2.0
DAMPING, CUBIC, DRIVE = 0.05, 0.1, 0.18


DUFFING = RestoringLaw(
    'duffing',
    'Krack and Gross 2019, NLvib example 01',
    lambda design: ((1.0, 0.0, CUBIC),) * 4,
    weighted=False,
    odd=DOFS,
)
EXAMPLE = Oscillator(DUFFING, 'vertical', PAPER_DESIGN, DAMPING / 2, DRIVE, falloff=2)

CURVES = {
    'duffing, NLvib example 01': (EXAMPLE, LOW, HIGH),
    'taylor vertical, H 0.078': (
        Oscillator(RESTORING['taylor'], 'vertical', PAPER_DESIGN, 0.07, 0.078), 0.1, 2,
    ),
    'closed_form vertical, H 0.1': (
        Oscillator(RESTORING['closed_form'], 'vertical', PAPER_DESIGN, 0.07, 0.1), 0.1, 2,
    ),
    'closed_form vertical, H 0.6': (
        Oscillator(RESTORING['closed_form'], 'vertical', PAPER_DESIGN, 0.02, 0.6), 0.1, 2,
    ),
    'corrected horizontal, H 0.1': (
        Oscillator(RESTORING['corrected'], 'horizontal', PAPER_DESIGN, 0.07, 0.1), 0.1, 2,
    ),
    'default of qzs-rig frf': (
        Oscillator.of(scenario.of({}), 'vertical', 0.1 / 0.6, 0), 0.02, 3,  # 0.1 m over L20
    ),
}  # fmt: skip


def best(work: Callable[[], object], repeats: int) -> float:
    """Seconds."""
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return min(times)


def by_harmonicbalance(harmonics: int, points: int, length: float) -> int:
    """Points that the arc-length continuation of harmonicbalance 0.2 takes."""
    from harmonicbalance.fourier import Fourier
    from harmonicbalance.predictorcorrector import PredictorCorrectorSolver

    push = Fourier(omega=HIGH, n=harmonics)
    push[1] = DRIVE

    def residual(x: Fourier) -> Fourier:
        return x.dt().dt() + DAMPING * x.dt() + x + CUBIC * x**3 - push

    start = Fourier(omega=HIGH, n=harmonics)
    start[1] = DRIVE / (1 - HIGH**2)
    solver = PredictorCorrectorSolver(residual, start, HIGH, LOW, length / points, method='hybr')
    with contextlib.redirect_stdout(io.StringIO()):  # it prints its times
        return len(solver.solve())


def by_mousai(harmonics: int, points: int) -> int:
    """Points that mousai's hb_freq solves of as many fixed frequencies."""
    import mousai

    def acceleration(x: object, v: object, params: dict[str, float]) -> object:
        push = DRIVE * math.cos(params['omega'] * params['cur_time'])
        return np.array([[push - x - CUBIC * x**3 - DAMPING * v]])

    first = np.zeros((1, 2 * harmonics + 1))
    first[0] = DRIVE / (1 - HIGH**2) * np.cos(2 * np.pi * np.arange(first.size) / first.size)
    x, done = first, 0
    with contextlib.redirect_stdout(io.StringIO()):
        for omega in np.linspace(HIGH, LOW, points):
            # anything may come out of scipy's Krylov solver near a fold
            with contextlib.suppress(Exception):
                _, x, *_ = mousai.hb_freq(acceleration, x, omega, num_harmonics=harmonics)
                done += 1
    return done


def arc_length(curve: Branch) -> float:
    """As harmonicbalance measures it, over coefficients and frequency alike."""
    points = np.column_stack([curve.coefficients, curve.omega])
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def branch(name: str, harmonics: int) -> Branch:
    """Down through the range of one of CURVES."""
    own, low, high = CURVES[name]
    return least_branch(own, low, high, 'down', harmonics).branches[0]


def ours(harmonics: int, repeats: int) -> None:
    """Tell what each of CURVES costs: one branch, and the whole response, isolas searched."""
    print(f'{"curve":30}{"points":>7}{"ms":>8}{"us/point":>10}{"all, ms":>9}  stable, ends')
    for name, (own, low, high) in CURVES.items():
        curve, n = branch(name, harmonics), len(branch(name, harmonics).omega)
        spent = best(lambda name=name: branch(name, harmonics), repeats)
        whole = best(lambda a=(own, low, high): frequency_response(*a), max(2, repeats // 10))
        print(
            f'{name:30}{n:7}{1e3 * spent:8.2f}{1e6 * spent / n:10.0f}{1e3 * whole:9.0f}  '
            f'{curve.stable.sum()}, {" and ".join(map(str, curve.ends))}'
        )


def peers(harmonics: int, repeats: int) -> None:
    """Tell what the others take for EXAMPLE, over our time."""
    name = next(iter(CURVES))
    curve = branch(name, harmonics)
    spent = best(lambda: branch(name, harmonics), repeats)
    points, length = len(curve.omega), arc_length(curve)
    print(f'\n{"duffing, " + str(harmonics) + " harmonics":30}{"points":>7}{"ms":>10}{"/ ours":>9}')
    print(f'{"qzs_rig, with Floquet":30}{points:7}{1e3 * spent:10.3f}{1:9}')
    for name, work in {
        'harmonicbalance': lambda: by_harmonicbalance(harmonics, points, length),
        'mousai': lambda: by_mousai(harmonics, points),
        'skhippr': None,
    }.items():
        try:
            __import__(name)
        except ImportError:
            print(f'{name:30}not installed: pip install {name}')
            continue
        if work is None:
            print(f'{name:30}installed, but never seen by the author: compare by hand')
            continue
        done: list[int] = []
        other = best(lambda work=work, done=done: done.append(work()), 5)
        print(f'{name:30}{done[-1]:7}{1e3 * other:10.1f}{other / spent:9.0f}')


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--harmonics', type=int, default=7)
    parser.add_argument('--repeats', type=int, default=20)
    args = parser.parse_args()
    ours(args.harmonics, args.repeats)
    peers(args.harmonics, args.repeats)


if __name__ == '__main__':
    main()
