"""One-harmonic motions of any law, all of them: the describing function as a table.

Magnus, Schwingungen (1961); MODEL section 5 is its case of a cubic law. A motion m + W cos(Ωτ + φ)
feels the force <F> = 0 on average and the stiffness N(W) on its fundamental.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from qzs_rig.samples import Array
from qzs_rig.theory.oscillator import Oscillator

SAMPLES = 48
LEVELS = 240
MEANS = 61


@dataclass(frozen=True)
class Describing:
    """Amplitudes W (n,), means m (n,) that balance the load, stiffness N (n,), and the `family`
    (n,) of neighbouring motions that each belongs to."""

    W: Array
    m: Array
    N: Array
    family: Array


def describing(oscillator: Oscillator) -> Describing:
    """The table for amplitudes up to what a hardening law or its domain lets through."""
    most = min(0.999 * oscillator.domain, 30.0 * max(1.0, oscillator.amplitude))
    levels = np.geomspace(1e-4 * min(1.0, oscillator.amplitude or 1.0), most, LEVELS)
    wave = np.cos(2 * np.pi * np.arange(SAMPLES) / SAMPLES)
    reach = np.minimum(4.0, 0.9999 * oscillator.domain - levels)
    # finer near 0, where quasi-zero stiffness makes wells close together
    side = np.linspace(0.0, 1.0, MEANS // 2 + 1) ** 2
    grid = reach[:, None] * np.concatenate([-side[:0:-1], side])

    def force(W: Array, m: Array) -> Array:
        return np.asarray(oscillator.force(m[..., None] + W[..., None] * wave))

    mean = force(np.broadcast_to(levels[:, None], grid.shape), grid).mean(axis=-1)
    rising = ~np.signbit(np.where(np.abs(mean) < 1e-15, 0.0, mean))
    level, place = np.nonzero(rising[:, :-1] != rising[:, 1:])
    W, low, high = levels[level], grid[level, place], grid[level, place + 1]
    goal = rising[level, place + 1]
    for _ in range(45):
        m = 0.5 * (low + high)
        above = (force(W, m).mean(axis=-1) >= 0) == goal
        low, high = np.where(above, low, m), np.where(above, m, high)
    m = 0.5 * (low + high)
    N = 2.0 * (force(W, m) * wave).mean(axis=-1) / W
    first = np.searchsorted(level, level)
    return Describing(W, m, N, (np.arange(len(level)) - first).astype(float))


def motions(oscillator: Oscillator, table: Describing, omega: float) -> Array:
    """(k, 3): mean, cos 1, sin 1 of the one-harmonic motions at Ω, interpolated in the table."""
    D, drive = 2 * oscillator.zeta * omega, float(oscillator.drive(omega))
    found = []
    for family in np.unique(table.family):
        own = table.family == family
        W, m, N = table.W[own], table.m[own], table.N[own]
        excess = np.log(W) + 0.5 * np.log((N - omega**2) ** 2 + D**2 + 1e-300) - np.log(drive)
        crossing = np.flatnonzero(np.signbit(excess[:-1]) != np.signbit(excess[1:]))
        for k in crossing:
            share = excess[k] / (excess[k] - excess[k + 1])
            at_W, at_m, at_N = (part[k] + share * (part[k + 1] - part[k]) for part in (W, m, N))
            found.append(_phased(at_W, at_m, at_N, omega, D, drive))
        # near a fold two crossings hide between two levels
        turning = 1 + np.flatnonzero(np.diff(np.sign(np.diff(np.abs(excess)))) > 0)
        near = turning[np.abs(excess[turning]) < 0.5]
        found += [_phased(W[k], m[k], N[k], omega, D, drive) for k in near]
    return np.array(found).reshape(-1, 3)


def _phased(W: float, m: float, N: float, omega: float, D: float, drive: float) -> list[float]:
    # (N - Ω² + iD) w = drive, its size taken from W
    w = W * np.exp(1j * np.angle(drive / (N - omega**2 + 1j * D)))
    return [m, float(w.real), float(-w.imag)]
