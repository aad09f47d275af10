"""The tracked-sine estimator: transmissibility along a sine whose frequency may move."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any, NamedTuple

import numpy as np

from qzs_rig.estimation.estimate import Curve, Estimate
from qzs_rig.estimation.events import find_events
from qzs_rig.estimation.plateaus import settle
from qzs_rig.estimation.settings import TrackedSineSettings
from qzs_rig.estimation.sine_fit import SineFitter
from qzs_rig.estimation.track import Track, sweep_runs, track_of, unrest
from qzs_rig.estimation.tracker import Point, SampleBuffer, Tracker, search_lengths
from qzs_rig.samples import NS, Array
from qzs_rig.units import DOFS


class Progress(NamedTuple):
    """How far an estimator has come: samples taken, points found over all degrees of freedom."""

    samples: int
    points: int


class TrackedSine:
    """Ratio of the fundamentals of top and base, followed window by window.

    Push uniformly sampled base and top signals of one quantity, acceleration or angular rate, one
    column a degree of freedom; the result is the same, bit by bit, however they are cut into
    chunks. Windows with a sample that is not finite, a faint base or a base that is no sine are
    left out and counted in `quality`. A sweep gives one curve a run up ('forward') or down
    ('reverse'); a dwell one averaged point, direction 'none', listed in quality['unsettled'] if
    the response did not come to rest.
    """

    name = 'tracked_sine'

    def __init__(
        self, settings: TrackedSineSettings, step_ns: int, dofs: Sequence[str] = DOFS
    ) -> None:
        """`dofs` names the columns, from qzs_rig.units.DOFS; `step_ns` is the sample step."""
        unknown = [dof for dof in dofs if dof not in DOFS]
        if unknown:
            raise ValueError(f'unknown degrees of freedom {unknown}; known are {list(DOFS)}')
        if step_ns <= 0:
            raise ValueError(f'step_ns = {step_ns} is not positive')
        step_s = step_ns / NS
        longest = search_lengths(settings, step_s)[-1]
        self._settings = settings
        self._step_ns = step_ns
        self._shape = (len(dofs),)
        self._buffer = SampleBuffer(len(dofs), longest)
        self._fitter = SineFitter(step_s, longest, settings.harmonics)
        self._trackers = {
            dof: Tracker(dof, column, settings, step_s) for column, dof in enumerate(dofs)
        }
        self._due = 0

    def push(self, base: Array, top: Array) -> None:
        """Take the next samples of base and top, (n, dofs) each, m/s² and rad/s."""
        if base.shape != top.shape or base.shape[1:] != self._shape:
            raise ValueError(
                f'base {base.shape} and top {top.shape} must both be (n, {self._shape[0]})'
            )
        first = 0
        while first < base.shape[0]:
            last = first + self._buffer.room
            self._buffer.append(base[first:last], top[first:last])
            first = last
            if self._buffer.end >= self._due:
                self._advance()

    @property
    def points(self) -> list[Point]:
        """All points so far, one degree of freedom after the other, each in order of time."""
        return [point for tracker in self._trackers.values() for point in tracker.points]

    @property
    def progress(self) -> Progress:
        """Samples taken and points found so far."""
        found = sum(len(tracker.points) for tracker in self._trackers.values())
        return Progress(self._buffer.end, found)

    def latest(self, dof: str) -> tuple[float, complex] | None:
        """Frequency (Hz) and T of the newest point of `dof`, None before the first one."""
        points = self._trackers[dof].points
        return (points[-1].frequency_hz, points[-1].transmissibility) if points else None

    def tracks(self) -> dict[str, Track]:
        """The points so far as columns, for each degree of freedom that has any."""
        return {
            dof: track_of(tracker.points)
            for dof, tracker in self._trackers.items()
            if tracker.points
        }

    def result(self) -> Estimate:
        """The curves and events of all samples pushed so far; may be called at any time."""
        curves: list[Curve] = []
        unsettled: list[dict[str, Any]] = []
        for dof, track in self.tracks().items():
            for run in sweep_runs(track.frequency_hz):
                part = track.slice(run.first, run.last)
                moved = unrest(
                    part.time_s,
                    part.frequency_hz,
                    np.abs(part.transmissibility),
                    self._settings.periods,
                )
                if run.direction == 'none':
                    part, moved = _dwell(dof, part, self._settings, unsettled)
                curves.append(part.curve(dof, run.direction, self.name, moved))
        events = tuple(event for curve in curves for event in find_events(curve))
        return Estimate(tuple(curves), events, self.quality() | {'unsettled': unsettled})

    def quality(self) -> dict[str, Any]:
        """JSON-ready: the settings, and per degree of freedom what became of the windows."""
        return {
            'estimator': self.name,
            'settings': asdict(self._settings),
            'step_ns': self._step_ns,
            'samples': self._buffer.end,
            'dofs': {
                dof: {
                    'points': len(tracker.points),
                    **tracker.counts,
                    'idle_s': tracker.idle_samples * self._step_ns / NS,
                    'base_residual': _median([p.base_residual for p in tracker.points]),
                    'top_residual': _median([p.top_residual for p in tracker.points]),
                }
                for dof, tracker in self._trackers.items()
            },
        }

    def _advance(self) -> None:
        trackers = self._trackers.values()
        for tracker in trackers:
            tracker.advance(self._buffer, self._fitter)
        self._due = min(tracker.needed for tracker in trackers)
        self._buffer.forget(min(tracker.start for tracker in trackers))


def _dwell(
    dof: str, track: Track, settings: TrackedSineSettings, unsettled: list[dict[str, Any]]
) -> tuple[Track, Array]:
    plateau = settle(track, settings)
    if not plateau.settled:
        unsettled.append(unsettled_report(dof, plateau.frequency_hz, plateau.scatter))
    point = Track(
        time_s=track.time_s[-1:],
        frequency_hz=np.array([plateau.frequency_hz]),
        transmissibility=np.array([plateau.transmissibility]),
        thd=np.array([plateau.thd]),
        amplitude=track.amplitude[-1:],
        noise=np.array([plateau.noise]),
    )
    return point, np.array([plateau.scatter])


def unsettled_report(dof: str, frequency_hz: float, scatter: float) -> dict[str, Any]:
    """An entry of quality['unsettled']."""
    return {'dof': dof, 'frequency_hz': frequency_hz, 'scatter': scatter}


def _median(values: list[float]) -> float | None:
    finite = [value for value in values if math.isfinite(value)]
    return float(np.median(finite)) if finite else None
