"""What an estimate costs per second of rig time, beside scipy.signal's H1, in one run.

The rig's tracked sine and a Welch H1 (csd / welch, one-second Hann segments, 50 % overlap) get the
same 120 s there-and-back sweep, 1-4-1 Hz at 500 Hz. H1 gives one smeared curve for both sweep
directions, no distortion and no events; it is the cheapest thing a user would reach for. A second
peer does what the tracked sine does, with the textbook tool: a four-period scipy.optimize
curve_fit of a chirped sine for each period of each signal, here on a tenth of the record.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from scipy import optimize, signal

from qzs_rig.estimation import TrackedSine, TrackedSineSettings

STEP_NS = 2_000_000
RATE = 1e9 / STEP_NS
LEG_S, LOW, HIGH = 60.0, 1.0, 4.0


def record() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Base and top (n, 4), all degrees of freedom excited, and the frequency (n,)."""
    t = np.arange(round(2 * LEG_S * RATE)) / RATE
    slope, back = (HIGH - LOW) / LEG_S, np.maximum(t - LEG_S, 0.0)
    frequency = LOW + slope * t - 2 * slope * back
    phase = 2 * np.pi * (LOW * t + slope * t**2 / 2 - slope * back**2)
    noise = 0.005 * np.random.default_rng(0).standard_normal((2, len(t), 4))
    base = np.sin(phase)[:, None] + noise[0]
    return base, 0.7 * np.sin(phase - 0.3)[:, None] + noise[1], frequency


def tracked(base: np.ndarray, top: np.ndarray, dofs: int, chunk: int) -> None:
    excited = np.arange(4) < dofs
    base, top = base * excited, top * excited
    estimator = TrackedSine(TrackedSineSettings(), STEP_NS)
    for first in range(0, len(base), chunk):
        estimator.push(base[first : first + chunk], top[first : first + chunk])
    estimator.result()


def welch_h1(base: np.ndarray, top: np.ndarray) -> None:
    segment = round(RATE)
    _, cross = signal.csd(base, top, RATE, 'hann', segment, axis=0)
    _, power = signal.welch(base, RATE, 'hann', segment, axis=0)
    _ = cross / power


def curve_fits(base: np.ndarray, top: np.ndarray, frequency: np.ndarray) -> None:
    """Nonlinear least squares window by window, frequency guessed perfectly."""

    def model(t: np.ndarray, *p: float) -> np.ndarray:
        phase = 2 * np.pi * (p[0] * t + p[1] * t**2 / 2)
        return p[2] * np.cos(phase) + p[3] * np.sin(phase) + p[4]

    centre = round(2 / frequency[0] * RATE)
    while centre + 2 / frequency[centre] * RATE < len(base):
        half = round(2 / frequency[centre] * RATE)
        t = np.arange(-half, half + 1) / RATE
        for values in (base, top):
            guess = (frequency[centre], 0.05, 0.5, 0.5, 0.0)
            optimize.curve_fit(model, t, values[centre - half : centre + half + 1], guess)
        centre += round(RATE / frequency[centre])


def cost(work: Callable[[], None], seconds: float, repeats: int = 5) -> float:
    """Best of `repeats`, microseconds per second of rig time."""
    best = np.inf
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - begin)
    return best / seconds * 1e6


def main() -> None:
    base, top, frequency = record()
    seconds, tenth = 2 * LEG_S, len(base) // 10
    h1 = cost(lambda: welch_h1(base, top), seconds)
    fits = cost(lambda: curve_fits(base[:tenth, 0], top[:tenth, 0], frequency), seconds / 10, 2)
    print('us per second of rig time          | / Welch H1, 4 dofs | / curve_fit, 1 dof')
    for name, value in (
        ('tracked sine, 1 dof', cost(lambda: tracked(base, top, 1, len(base)), seconds)),
        ('tracked sine, 1 dof, chunks of 20', cost(lambda: tracked(base, top, 1, 20), seconds)),
        ('tracked sine, 4 dofs', cost(lambda: tracked(base, top, 4, len(base)), seconds)),
        ('scipy Welch H1, 4 dofs', h1),
        ('scipy curve_fit, 1 dof', fits),
    ):
        print(f'{name:34} {value:8.0f} | {value / h1:17.2f} | {value / fits:8.4f}')


if __name__ == '__main__':
    main()
