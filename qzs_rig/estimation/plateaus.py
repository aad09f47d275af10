"""Plateaus of constant frequency in a track, and whether the response settled on them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from qzs_rig.estimation.settings import TrackedSineSettings
from qzs_rig.estimation.track import Track
from qzs_rig.samples import Array

STEADY = 0.02
"""Relative change of the base amplitude that still is no ramp."""


class Plateau(NamedTuple):
    """One step: mean frequency (Hz), T and distortion over the `points` that agree at its end;
    `scatter` is the largest |T - mean T| / |mean T| there, `settled` whether it is tolerated,
    `noise` the relative uncertainty of one of those points.
    The mean of an unsettled plateau is that of its later half."""

    frequency_hz: float
    transmissibility: complex
    thd: float
    points: int
    scatter: float
    settled: bool
    noise: float


def plateau_bounds(frequency_hz: Array, tolerance: float) -> list[tuple[int, int]]:
    """Stretches [first, last) of (n,) whose points stay within `tolerance` of their mean."""
    bounds: list[tuple[int, int]] = []
    first, total = 0, 0.0
    values = frequency_hz.tolist()
    for i, value in enumerate(values):
        count = i - first
        if count and abs(value - total / count) > tolerance * value:
            bounds.append((first, i))
            first, total = i, 0.0
        total += value
    if values:
        bounds.append((first, len(values)))
    return bounds


def settle(track: Track, settings: TrackedSineSettings) -> Plateau:
    """The end of the plateau `track`, its ramps left out, averaged over the points that agree."""
    first, last = _longest(_steady(track, settings))
    count = math.ceil(settings.settle_periods / settings.hop_periods) + 1
    reach = _reach(settings)
    if last - first >= count + reach:
        last -= reach  # these windows may already see the glide to the next step
    part = track.slice(first, last)
    values = part.transmissibility
    tail = values[-count:]
    scatter = _deviation(tail, complex(tail.mean()))
    settled = len(values) >= count and bool(scatter.max() <= settings.settle_tolerance)
    if settled:
        agreeing = _deviation(values, complex(tail.mean())) <= settings.settle_tolerance
        first = len(values) - int(np.argmin(agreeing[::-1])) if not agreeing.all() else 0
    else:
        first = len(values) // 2
    return Plateau(
        frequency_hz=float(part.frequency_hz[first:].mean()),
        transmissibility=complex(values[first:].mean()),
        thd=float(part.thd[first:].mean()),
        points=len(values) - first,
        scatter=float(scatter.max()),
        settled=settled,
        noise=float(part.noise[first:].mean()),
    )


def _steady(track: Track, settings: TrackedSineSettings) -> NDArray[np.bool_]:
    """Points whose whole window saw the plateau's own base amplitude."""
    usual = float(np.median(track.amplitude))
    off = np.abs(track.amplitude - usual) > STEADY * usual
    reach = _reach(settings)
    widened = np.convolve(off, np.ones(2 * reach + 1))[reach : reach + len(off)] > 0.5
    return ~off if bool(widened.all()) else ~widened


def _reach(settings: TrackedSineSettings) -> int:
    """Points on either side of a point whose windows reach its centre."""
    return math.ceil(settings.periods / settings.hop_periods / 2)


def _longest(mask: NDArray[np.bool_]) -> tuple[int, int]:
    """Bounds of the longest stretch of True; everything if there is none."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    if not len(edges):
        return 0, len(mask)
    best = int(np.argmax(edges[1::2] - edges[::2]))
    return int(edges[2 * best]), int(edges[2 * best + 1])


def _deviation(values: NDArray[np.complex128], mean: complex) -> Array:
    return np.abs(values - mean) / (abs(mean) or math.inf)
