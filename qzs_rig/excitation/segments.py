"""Pieces of a frequency plan, each with its phase in closed form: no sum, so no drift."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from qzs_rig.samples import Array


class Cycles(NamedTuple):
    """Phase in cycles and its first three time derivatives (Hz, Hz/s, Hz/s²), each (n,)."""

    phase: Array
    frequency: Array
    rate: Array
    curvature: Array


class Segment(Protocol):
    """`duration` seconds of a plan; `cycles(t)` for t from 0 at its start."""

    @property
    def duration(self) -> float: ...

    def cycles(self, t: Array) -> Cycles: ...


@dataclass(frozen=True)
class Dwell:
    """Constant frequency in Hz."""

    frequency_hz: float
    duration: float

    def cycles(self, t: Array) -> Cycles:
        zero = np.zeros_like(t)
        return Cycles(self.frequency_hz * t, zero + self.frequency_hz, zero, zero)


@dataclass(frozen=True)
class LinearChirp:
    """Frequency linear in time from `start_hz` to `end_hz`."""

    start_hz: float
    end_hz: float
    duration: float

    def cycles(self, t: Array) -> Cycles:
        rate = (self.end_hz - self.start_hz) / self.duration
        zero = np.zeros_like(t)
        return Cycles(
            (self.start_hz + 0.5 * rate * t) * t, self.start_hz + rate * t, zero + rate, zero
        )


@dataclass(frozen=True)
class Ease:
    """The sweep rate on half a cosine from `start_rate` to `end_rate` (Hz/s)."""

    start_hz: float
    start_rate: float
    end_rate: float
    duration: float

    @property
    def end_hz(self) -> float:
        """Frequency at the end of the segment."""
        return self.start_hz + 0.5 * (self.start_rate + self.end_rate) * self.duration

    def cycles(self, t: Array) -> Cycles:
        half = 0.5 * (self.end_rate - self.start_rate)
        mean = 0.5 * (self.end_rate + self.start_rate)
        w = math.pi / self.duration
        sin, cos = np.sin(w * t), np.cos(w * t)
        return Cycles(
            (self.start_hz + 0.5 * mean * t) * t - half / w**2 * (1.0 - cos),
            self.start_hz + mean * t - half / w * sin,
            mean - half * cos,
            half * w * sin,
        )


@dataclass(frozen=True)
class LogChirp:
    """Frequency exponential in time: equal time an octave."""

    start_hz: float
    end_hz: float
    duration: float

    def cycles(self, t: Array) -> Cycles:
        growth = math.log(self.end_hz / self.start_hz) / self.duration
        frequency = self.start_hz * np.exp(growth * t)
        return Cycles(
            self.start_hz * np.expm1(growth * t) / growth,
            frequency,
            growth * frequency,
            growth**2 * frequency,
        )


@dataclass(frozen=True)
class Glide:
    """Frequency on half a cosine between two dwells: a step that a shaker can follow."""

    start_hz: float
    end_hz: float
    duration: float

    def cycles(self, t: Array) -> Cycles:
        half = 0.5 * (self.end_hz - self.start_hz)
        w = math.pi / self.duration
        sin, cos = np.sin(w * t), np.cos(w * t)
        return Cycles(
            self.start_hz * t + half * (t - sin / w),
            self.start_hz + half * (1.0 - cos),
            half * w * sin,
            half * w * w * cos,
        )
