"""Estimators: from base and top signals to transmissibility curves and events."""

from __future__ import annotations

from qzs_rig.estimation.settings import TrackedSineSettings
from qzs_rig.estimation.stepped_sine import SteppedSine
from qzs_rig.estimation.tracked_sine import TrackedSine

ESTIMATORS: dict[str, type[TrackedSine] | type[SteppedSine]] = {
    'tracked_sine': TrackedSine,
    'stepped_sine': SteppedSine,
}
"""Estimators by name: `ESTIMATORS[name](settings, step_ns)`, then push, latest, result."""

__all__ = ['ESTIMATORS', 'SteppedSine', 'TrackedSine', 'TrackedSineSettings']
