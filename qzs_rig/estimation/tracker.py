"""Following the tone of one degree of freedom: search, lock, hop from window to window, lose."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from qzs_rig.estimation.acquisition import find_tone
from qzs_rig.estimation.settings import TrackedSineSettings
from qzs_rig.estimation.sine_fit import SineFit, SineFitter
from qzs_rig.samples import Array

SEARCH_S = 0.5
LADDER = 1.5
"""A search starts with SEARCH_S seconds and takes LADDER times more until enough periods fit."""
COUNTS = ('windows', 'locks', 'misfit', 'ramping', 'faint', 'not_finite')
"""Windows fitted, tones found, and windows dropped by reason."""
REFINEMENTS = 2
FIRST_REFINEMENTS = 8
CHIRP_MEMORY = 0.7
"""Share of the old sweep rate kept in the prediction; keeps noise out of the next reference."""
CLEAR = 6.0
"""Standard deviations by which a fundamental must exceed the noise of its own fit."""

GROWTH = 1.0
"""Relative change of the base amplitude over half a window above which it comes from nothing."""


class Point(NamedTuple):
    """One window: time of its centre (s since sample 0), the base's frequency (Hz) and sweep rate
    (Hz/s) there, T = top / base, the top's distortion, the base's amplitude (m/s² or rad/s),
    the residuals of both fits, rms over the fundamental's rms, and the samples of the window."""

    time_s: float
    dof: str
    frequency_hz: float
    chirp: float
    transmissibility: complex
    thd: float
    base_amplitude: float
    base_residual: float
    top_residual: float
    samples: int


class _Lock(NamedTuple):
    centre: int
    half: int
    frequency_hz: float
    chirp: float


class Tracker:
    """Owns the points and the counts of one degree of freedom. Every decision is made at a sample
    index that depends on the signal alone, never on how it was cut into chunks."""

    def __init__(self, dof: str, column: int, settings: TrackedSineSettings, step_s: float) -> None:
        self.dof = dof
        self.points: list[Point] = []
        self.counts = dict.fromkeys(COUNTS, 0)
        self.idle_samples = 0
        self.start = 0
        """First sample that is still needed."""
        self.needed = 0
        """Number of samples that must have arrived before the next step."""
        self._column = column
        self._settings = settings
        self._step_s = step_s
        self._floor = settings.floor(dof)
        self._low, self._high = band(settings, step_s)
        self._ladder = search_lengths(settings, step_s)
        self._rung = 0
        self._last_centre = -1
        self._lock: _Lock | None = None
        self._search_at(0, 0)

    def advance(self, buffer: SampleBuffer, fitter: SineFitter) -> None:
        """Take every step that the samples in `buffer` allow."""
        while self.needed <= buffer.end:
            if self._lock is None:
                self._search(buffer, fitter)
            else:
                self._follow(self._lock, buffer, fitter)

    def _follow(self, lock: _Lock, buffer: SampleBuffer, fitter: SineFitter) -> None:
        window = self._window(lock, buffer)
        fit = fitter.refine(window, lock.frequency_hz, lock.chirp, REFINEMENTS)
        if abs(fit.frequency_hz / lock.frequency_hz - 1.0) < 0.1 and self._accepted(
            fit, window, fitter
        ):
            self._record(lock, fit)
            chirp = CHIRP_MEMORY * lock.chirp + (1.0 - CHIRP_MEMORY) * fit.chirp
            self._follow_from(lock, fit.frequency_hz, chirp)
        else:
            self._search_at(self.start, 0)

    def _search(self, buffer: SampleBuffer, fitter: SineFitter) -> None:
        length = self._ladder[self._rung]
        base = buffer.window(self._column, self.start, self.start + length)[0]
        swing = float(base.max() - base.min())
        if not math.isfinite(swing):
            self.counts['not_finite'] += 1
            self._search_at(self.start + 1 + int(np.flatnonzero(~np.isfinite(base))[-1]), 0)
            return
        tone = (
            find_tone(base, self._step_s, self._settings.chirp_max) if swing > self._floor else None
        )
        if tone is None:
            self._pass_over()
        elif tone.frequency_hz * (length - 2) * self._step_s < self._settings.periods:
            self._look_longer()
        else:
            self._try_lock(tone.frequency_hz, tone.chirp, length, buffer, fitter)

    def _look_longer(self) -> None:
        if self._rung + 1 < len(self._ladder):
            self._search_at(self.start, self._rung + 1)
        else:
            self._pass_over()

    def _try_lock(
        self,
        frequency_hz: float,
        chirp: float,
        length: int,
        buffer: SampleBuffer,
        fitter: SineFitter,
    ) -> None:
        if not self._in_band(frequency_hz):
            self._pass_over()
            return
        half = self._half(frequency_hz)
        at_centre = frequency_hz - chirp * (length / 2 - half) * self._step_s
        lock = _Lock(self.start + half, half, at_centre, chirp)
        if lock.centre > self._last_centre and self._in_band(at_centre):
            window = self._window(lock, buffer)
            fit = fitter.refine(window, at_centre, chirp, FIRST_REFINEMENTS)
            if self._accepted(fit, window, fitter):
                self.counts['locks'] += 1
                self._record(lock, fit)
                self._follow_from(lock, fit.frequency_hz, fit.chirp)
                return
        hop = max(1, round(0.5 / (frequency_hz * self._step_s)))
        self._search_at(self.start + hop, max(0, self._rung - 2))

    def _pass_over(self) -> None:
        self.idle_samples += self._ladder[0]
        self._search_at(self.start + self._ladder[0], 0)

    def _accepted(self, fit: SineFit, window: Array, fitter: SineFitter) -> bool:
        """Whether the window shows one clear tone; counts the reason if not."""
        self.counts['windows'] += 1
        amplitude, residual = abs(fit.base), fit.base_residual
        if not math.isfinite(residual + fit.top_residual):
            self.counts['not_finite'] += 1
            return False
        if amplitude < self._floor or CLEAR * 2.0 * residual > math.sqrt(window.shape[1]):
            self.counts['faint'] += 1
            return False
        if fit.growth > GROWTH:
            self.counts['ramping'] += 1
            return False
        if residual > self._settings.residual_max:
            residual = fitter.tonal_misfit(window, fit)
        good = self._in_band(fit.frequency_hz) and residual <= self._settings.residual_max
        self.counts['misfit'] += not good
        return good

    def _record(self, lock: _Lock, fit: SineFit) -> None:
        self._last_centre = lock.centre
        self.points.append(
            Point(
                lock.centre * self._step_s,
                self.dof,
                fit.frequency_hz,
                fit.chirp,
                fit.top / fit.base,
                fit.thd,
                abs(fit.base),
                fit.base_residual,
                fit.top_residual,
                2 * lock.half + 1,
            )
        )

    def _follow_from(self, lock: _Lock, frequency_hz: float, chirp: float) -> None:
        hop = max(1, round(self._settings.hop_periods / (frequency_hz * self._step_s)))
        ahead = frequency_hz + chirp * hop * self._step_s
        if not self._in_band(ahead):
            self._search_at(lock.centre, 0)
            return
        half = self._half(ahead)
        centre = max(lock.centre + hop, self.start + half)
        self._lock = _Lock(centre, half, ahead, chirp)
        self.start, self.needed = centre - half, centre + half + 1

    def _search_at(self, start: int, rung: int) -> None:
        self._lock = None
        self._rung = rung
        self.start, self.needed = start, start + self._ladder[rung]

    def _window(self, lock: _Lock, buffer: SampleBuffer) -> Array:
        return buffer.window(self._column, lock.centre - lock.half, lock.centre + lock.half + 1)

    def _half(self, frequency_hz: float) -> int:
        return round(0.5 * self._settings.periods / (frequency_hz * self._step_s))

    def _in_band(self, frequency_hz: float) -> bool:
        return self._low <= frequency_hz <= self._high


def band(settings: TrackedSineSettings, step_s: float) -> tuple[float, float]:
    """Lowest and highest frequency followed, Hz: the settings', within 0.8 Nyquist."""
    return settings.frequency_min, min(settings.frequency_max, 0.4 / step_s)


def search_lengths(settings: TrackedSineSettings, step_s: float) -> list[int]:
    """Samples of the stretches in which a tone is looked for, shortest first; the longest holds a
    window of the lowest frequency."""
    longest = math.ceil(settings.periods / (settings.frequency_min * step_s)) + 4
    lengths = [max(8, round(SEARCH_S / step_s))]
    while lengths[-1] < longest:
        lengths.append(min(longest, math.ceil(LADDER * lengths[-1])))
    return lengths


class SampleBuffer:
    """The recent samples [start, end) of base and top, contiguous, addressed by their index since
    sample 0; the owner forgets what it no longer needs."""

    def __init__(self, columns: int, capacity: int) -> None:
        """Room for `capacity` samples that are not forgotten yet."""
        self._data = np.empty((columns, 2, 2 * capacity))
        self._origin = 0
        self.start = 0
        self.end = 0

    @property
    def room(self) -> int:
        """Samples that can be appended now."""
        return self._data.shape[2] - (self.end - self.start)

    def append(self, base: Array, top: Array) -> None:
        """Copy `base`, `top` (n, columns) behind the last sample; n must not exceed `room`."""
        n = base.shape[0]
        if self.end + n - self._origin > self._data.shape[2]:
            self._compact()
        place = slice(self.end - self._origin, self.end - self._origin + n)
        self._data[:, 0, place] = base.T
        self._data[:, 1, place] = top.T
        self.end += n

    def forget(self, before: int) -> None:
        """Release the samples before index `before`."""
        self.start = max(self.start, min(before, self.end))

    def window(self, column: int, first: int, last: int) -> Array:
        """Base and top of `column` over [first, last), (2, last - first), a view."""
        return self._data[column, :, first - self._origin : last - self._origin]

    def _compact(self) -> None:
        kept = self._data[:, :, self.start - self._origin : self.end - self._origin].copy()
        self._data[:, :, : kept.shape[2]] = kept
        self._origin = self.start
