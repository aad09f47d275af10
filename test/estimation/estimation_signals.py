"""Signals with known answers: swept and stepped sines, exact responses of linear platforms."""

from __future__ import annotations

import numpy as np
from scipy import signal

STEP_NS = 2_000_000
STEP_S = STEP_NS / 1e9
NATURAL = 20.0


def times(duration_s):
    return np.arange(round(duration_s / STEP_S)) * STEP_S


def sine(t, frequency_hz, amplitude=1.0, phase=0.0):
    return amplitude * np.sin(2 * np.pi * frequency_hz * t + phase)


def there_and_back(t, low_hz, high_hz, leg_s):
    """Frequency (Hz) and phase (rad) of a linear sweep up and down again."""
    rate = (high_hz - low_hz) / leg_s
    back = np.maximum(t - leg_s, 0.0)
    phase = low_hz * t + rate * t**2 / 2 - rate * back**2
    return low_hz + rate * t - 2 * rate * back, 2 * np.pi * phase


def closed_form(frequency_hz, zeta, natural=NATURAL):
    """T of a linear base-excited platform, complex (ISO 18437-4, absolute transmissibility)."""
    x = 2 * np.pi * frequency_hz / natural
    return (1 + 2j * zeta * x) / (1 - x**2 + 2j * zeta * x)


def linear_top(base, step_s, zeta, natural=NATURAL):
    """Top acceleration for the base acceleration `base` (n,), started from rest, exact for an
    input that is straight between samples."""
    system = ([2 * zeta * natural, natural**2], [1, 2 * zeta * natural, natural**2])
    numerator, denominator, _ = signal.cont2discrete(system, step_s, method='foh')
    return signal.lfilter(numerator.ravel(), denominator, base)


def columns(*signals):
    """Signals (n,) as the first of four columns, the others at rest."""
    data = np.zeros((len(signals[0]), 4))
    for column, values in enumerate(signals):
        data[:, column] = values
    return data


def pushed(estimator, base, top, chunk=None):
    chunk = chunk or len(base)
    for first in range(0, len(base), chunk):
        estimator.push(base[first : first + chunk], top[first : first + chunk])
    return estimator


def complex_t(curve):
    return curve.magnitude * np.exp(1j * np.radians(curve.phase_deg))
