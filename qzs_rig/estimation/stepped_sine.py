"""The stepped-sine estimator: one settled, averaged point for each plateau of the frequency."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from qzs_rig.estimation.estimate import Curve, Estimate
from qzs_rig.estimation.events import find_events
from qzs_rig.estimation.plateaus import Plateau, plateau_bounds, settle
from qzs_rig.estimation.settings import TrackedSineSettings
from qzs_rig.estimation.track import Track, monotone_runs
from qzs_rig.estimation.tracked_sine import TrackedSine, unsettled_report
from qzs_rig.estimation.tracker import Point
from qzs_rig.samples import Array
from qzs_rig.units import DOFS


class SteppedSine:
    """Tracks the sine like TrackedSine, then averages each plateau once its windows agree.

    A step that never settles is left out of the curve and listed in quality['unsettled']; a
    stretch of constant frequency shorter than two windows is no step and counted in
    quality['fragments']. Rising steps make a 'forward' curve, falling ones 'reverse', a single
    step (a dwell) 'none'.
    """

    name = 'stepped_sine'

    def __init__(
        self, settings: TrackedSineSettings, step_ns: int, dofs: Sequence[str] = DOFS
    ) -> None:
        """As TrackedSine; the settle and plateau settings decide what a settled step is."""
        self._settings = settings
        self._tracking = TrackedSine(settings, step_ns, dofs)

    def push(self, base: Array, top: Array) -> None:
        """Take the next samples of base and top, (n, dofs) each, m/s² and rad/s."""
        self._tracking.push(base, top)

    @property
    def points(self) -> list[Point]:
        """All tracked points so far, settled or not."""
        return self._tracking.points

    def latest(self, dof: str) -> tuple[float, complex] | None:
        """Frequency (Hz) and T of the newest tracked point of `dof`, None before the first."""
        return self._tracking.latest(dof)

    def result(self) -> Estimate:
        """The settled steps of all samples pushed so far; may be called at any time."""
        curves: list[Curve] = []
        unsettled: list[dict[str, Any]] = []
        fragments = 0
        for dof, track in self._tracking.tracks().items():
            bounds = plateau_bounds(track.frequency_hz, self._settings.plateau_tolerance)
            steps = [part for part in bounds if self._is_step(track.slice(*part))]
            fragments += len(bounds) - len(steps)
            plateaus = [settle(track.slice(*step), self._settings) for step in steps]
            unsettled += [
                unsettled_report(dof, plateau.frequency_hz, plateau.scatter)
                for plateau in plateaus
                if not plateau.settled
            ]
            curves += self._curves(dof, [plateau for plateau in plateaus if plateau.settled])
        events = tuple(event for curve in curves for event in find_events(curve, settled=True))
        quality = self._tracking.quality() | {
            'estimator': self.name,
            'unsettled': unsettled,
            'fragments': fragments,
        }
        return Estimate(tuple(curves), events, quality)

    def _is_step(self, part: Track) -> bool:
        """Longer than two windows in a row, first sample to last."""
        lasted = float((part.time_s[-1] - part.time_s[0]) * part.frequency_hz.mean())
        return lasted > self._settings.periods * 0.99

    def _curves(self, dof: str, steps: list[Plateau]) -> list[Curve]:
        track = Track(
            time_s=np.arange(len(steps), dtype=np.float64),
            frequency_hz=np.array([step.frequency_hz for step in steps]),
            transmissibility=np.array([step.transmissibility for step in steps], np.complex128),
            thd=np.array([step.thd for step in steps]),
            amplitude=np.ones(len(steps)),
            noise=np.array([step.noise for step in steps]),
        )
        scatter = np.array([step.scatter for step in steps])
        return [
            track.slice(run.first, run.last).curve(
                dof, run.direction, self.name, scatter[run.first : run.last]
            )
            for run in monotone_runs(track.frequency_hz, 0.0)
        ]
