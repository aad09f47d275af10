"""Finding a tone of unknown frequency and sweep rate in a stretch of the base signal."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from qzs_rig.samples import Array

TONAL = 0.5
"""Share of the power within two bins of the peak (half of a Hann window's four-bin main lobe and
its neighbours) above which a stretch is taken for one tone."""
PURE = 0.9
"""Share above which no sweep needs to be looked for."""
CHIRPS = 6
"""Sweep rates tried either side of zero."""


class Tone(NamedTuple):
    """A candidate: frequency at the middle of the stretch (Hz), sweep rate (Hz/s)."""

    frequency_hz: float
    chirp: float


def find_tone(stretch: Array, step_s: float, chirp_max: float) -> Tone | None:
    """The strongest tone of `stretch` (n,), steady or linearly swept within ± `chirp_max`;
    None if no tone stands out. Frequency within about 0.2 bins, to be refined by a fit."""
    n = stretch.shape[0]
    taper = np.hanning(n + 2)[1:-1]
    tapered = (stretch - stretch.mean()) * taper
    tapered -= taper * (tapered.sum() / taper.sum())
    power = np.abs(np.fft.rfft(tapered)) ** 2
    share = _peak_share(power)
    if share >= PURE:
        return Tone(_interpolated(power) / (n * step_s), 0.0)
    chirps, powers = _dechirped(tapered, step_s, chirp_max)
    best = int(np.argmax(powers.max(axis=1)))
    if _peak_share(powers[best]) < TONAL:
        return None
    return Tone(_interpolated(powers[best]) / (n * step_s), float(chirps[best]))


def _dechirped(tapered: Array, step_s: float, chirp_max: float) -> tuple[Array, Array]:
    """Power spectra (m, bins) after taking out each of m sweep rates, a quarter turn of phase
    apart at the ends."""
    n = tapered.shape[0]
    length_s = n * step_s
    spacing = 1.0 / length_s**2
    count = min(CHIRPS, math.ceil(chirp_max / spacing))
    chirps = np.arange(-count, count + 1) * max(spacing, chirp_max / max(count, 1))
    t = (np.arange(n) - (n - 1) / 2) * step_s
    turned = tapered * np.exp(-1j * np.pi * chirps[:, None] * t**2)
    return chirps, np.abs(np.fft.fft(turned, axis=1)[:, : n // 2 + 1]) ** 2


def _peak_share(power: Array) -> float:
    total = float(power.sum())
    peak = int(np.argmax(power))
    return float(power[max(peak - 2, 0) : peak + 3].sum()) / total if total > 0.0 else 0.0


def _interpolated(power: Array) -> float:
    """Bin of the peak, with the fraction a Hann window shows in its two largest bins."""
    peak = int(np.argmax(power))
    if not 0 < peak < power.shape[0] - 1:
        return float(peak)
    below, at, above = np.sqrt(power[peak - 1 : peak + 2]).tolist()
    if above >= below:
        return float(peak + (2.0 * above - at) / (above + at))
    return float(peak - (2.0 * below - at) / (below + at))
