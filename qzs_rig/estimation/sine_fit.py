"""One window of base and top, fitted with a chirped sine, its harmonics and an offset.

Weighted linear least squares on the sample times of y = y0 + Re[(c0 + c1 u + c2 u²) e^{iφ}]
+ Σ Re[h_k e^{ikφ}], φ = 2π f t + π r t², t = 0 at the window centre, u = t over half the window,
weight (1 - u²)². The slowly varying envelope takes ramps and resonances; its phase at the centre
tells how far the reference (f, r) was off.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from qzs_rig.samples import Array

FUNDAMENTAL = slice(1, 7)
PHASE_TOLERANCE = 0.03
"""rad at the window's edge; the envelope absorbs this much with an error of 0.03³/6 = 5e-6."""


class SineFit(NamedTuple):
    """What one window shows. `base`, `top` are complex amplitudes at its centre (of e^{iφ});
    residuals are rms over the rms of the fundamental; `phase_error` (rad, at the window's edge)
    is how far the reference (Hz, Hz/s) missed the base, `growth` the base's relative change of
    amplitude over half a window."""

    frequency_hz: float
    chirp: float
    base: complex
    top: complex
    thd: float
    base_residual: float
    top_residual: float
    phase_error: float
    growth: float
    reference_hz: float
    reference_chirp: float


class SineFitter:
    """Fits windows of one sample step; owns only scratch, so equal inputs give equal results."""

    def __init__(self, step_s: float, longest: int, harmonics: int) -> None:
        """`longest` is the largest window that will be asked for, samples."""
        self._step_s = step_s
        self._harmonics = harmonics
        # One buffer for all windows: the bits must not depend on where an array was put.
        self._scratch = np.empty((2 * harmonics + 7) * longest + 8)

    def refine(self, window: Array, frequency_hz: float, chirp: float, attempts: int) -> SineFit:
        """The fit of `window` (2, n), n odd, with the reference corrected up to `attempts` times
        until it follows the base within PHASE_TOLERANCE."""
        fit = self.fit(window, frequency_hz, chirp)
        for _ in range(attempts):
            if not PHASE_TOLERANCE < fit.phase_error < 2 * math.pi or fit.frequency_hz <= 0.0:
                break
            fit = self.fit(window, fit.frequency_hz, fit.chirp)
        return fit

    def fit(self, window: Array, frequency_hz: float, chirp: float) -> SineFit:
        """The linear fit of `window` (2, n), base above top, with the reference as given."""
        _, gram, solution = self._solved(window, frequency_hz, chirp)
        return _read(gram, solution, frequency_hz, chirp, self._half_s(window))

    def tonal_misfit(self, window: Array, fit: SineFit) -> float:
        """Residual of the base in `window`, which `fit` describes, that neighbouring samples share,
        over its fundamental (both rms): the covariance at a sixteenth of a period, where white
        noise has lost its memory and a badly tracked tone has kept cos(π/8) of it."""
        design, _, solutions = self._solved(window, fit.reference_hz, fit.reference_chirp)
        solution = solutions[:, 0]
        size = solution.shape[0]
        residual = design[size] - solution @ design[:size]
        lag = max(1, round(1.0 / (16.0 * fit.frequency_hz * self._step_s)))
        root = design[0]
        shared = abs(float(residual[lag:] @ residual[:-lag])) / float(root[lag:] @ root[:-lag])
        return math.sqrt(2.0 * shared) / math.hypot(float(solution[1]), float(solution[2]))

    def _solved(
        self, window: Array, frequency_hz: float, chirp: float
    ) -> tuple[Array, Array, Array]:
        """Weighted rows (see _design; scratch until the next call), their products, and the
        solution (size, 2) for base and top."""
        kept = self._harmonics_below(0.4 / self._step_s, frequency_hz)
        design = self._design(window, self._half_s(window), frequency_hz, chirp, kept)
        gram = design @ design.T
        size = gram.shape[0] - 2
        return design, gram, np.linalg.solve(gram[:size, :size], gram[:size, size:])

    def _half_s(self, window: Array) -> float:
        return float((window.shape[1] // 2 + 1) * self._step_s)

    def _harmonics_below(self, limit_hz: float, frequency_hz: float) -> int:
        return max(1, min(self._harmonics, int(limit_hz / frequency_hz)))

    def _design(
        self, window: Array, half_s: float, frequency_hz: float, chirp: float, harmonics: int
    ) -> Array:
        """Rows, each times the root of the weight: 1 | cos, sin | u cos, u sin | u² cos, u² sin |
        cos kφ, sin kφ for k = 2... | base | top. Harmonics by Chebyshev's recurrence."""
        n = window.shape[1]
        rows = 2 * harmonics + 7
        design = self._scratch[: rows * n].reshape(rows, n)
        u = np.arange(-(n // 2), n // 2 + 1) * (self._step_s / half_s)
        phase = u * (2.0 * math.pi * frequency_hz * half_s + (math.pi * chirp * half_s**2) * u)
        root = np.subtract(1.0, u * u, out=design[0])
        np.cos(phase, out=design[1])
        np.sin(phase, out=design[2])
        twice = design[1] * 2.0
        design[1:3] *= root
        np.multiply(design[1:3], u, out=design[3:5])
        np.multiply(design[3:5], u, out=design[5:7])
        below, last = None, design[1:3]
        for k in range(2, harmonics + 1):
            row = np.multiply(last, twice, out=design[2 * k + 3 : 2 * k + 5])
            if below is None:
                row[0] -= root
            else:
                row -= below
            below, last = last, row
        np.multiply(window, root, out=design[rows - 2 :])
        return design


def _read(
    gram: Array, solution: Array, frequency_hz: float, chirp: float, half_s: float
) -> SineFit:
    size = solution.shape[0]
    base, top = solution[:, 0].tolist(), solution[:, 1].tolist()
    weight = float(gram[0, 0])
    c0, c1, c2 = (complex(base[k], -base[k + 1]) for k in (1, 3, 5))
    top0 = complex(top[1], -top[2])
    # Logarithmic derivatives of the base's envelope: what the reference missed.
    first, second = (c1 / c0, c2 / c0) if c0 else (complex('nan'), complex('nan'))
    slope, bend = first.imag, (2.0 * second - first**2).imag
    explained = np.einsum('ij,ij->j', solution, gram[:size, size:]).tolist()
    return SineFit(
        frequency_hz=frequency_hz + slope / (2.0 * math.pi * half_s),
        chirp=chirp + bend / (2.0 * math.pi * half_s**2),
        base=c0,
        top=top0,
        thd=_thd(top[7:], abs(top0)),
        base_residual=_relative(float(gram[size, size]) - explained[0], weight, abs(c0)),
        top_residual=_relative(float(gram[-1, -1]) - explained[1], weight, abs(top0)),
        phase_error=abs(slope) + 0.5 * abs(bend),
        growth=abs(first.real),
        reference_hz=frequency_hz,
        reference_chirp=chirp,
    )


def _thd(harmonics: list[float], fundamental: float) -> float:
    if not harmonics or not fundamental:
        return math.nan
    return math.hypot(*harmonics) / fundamental


def _relative(square: float, weight: float, amplitude: float) -> float:
    if not amplitude or math.isnan(square):
        return math.nan
    return math.sqrt(2.0 * max(square, 0.0) / weight) / amplitude
