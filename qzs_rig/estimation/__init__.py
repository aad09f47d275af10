"""Estimators: from base and top signals to transmissibility curves and events. A new estimator is
one file and one line in ESTIMATORS."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from qzs_rig.estimation import channels, settings
from qzs_rig.estimation.estimate import Estimate
from qzs_rig.estimation.settings import TrackedSineSettings
from qzs_rig.estimation.stepped_sine import SteppedSine
from qzs_rig.estimation.tracked_sine import TrackedSine
from qzs_rig.parameters import Parameter
from qzs_rig.samples import Array


class Estimator(Protocol):
    """Takes base and top sample by sample; the result never depends on how they were cut."""

    name: str
    """The name it is listed under."""

    def __init__(
        self, settings: TrackedSineSettings, step_ns: int, dofs: Sequence[str]
    ) -> None: ...

    def push(self, base: Array, top: Array) -> None:
        """Take the next samples of base and top, (n, dofs) each, m/s² and rad/s."""

    def latest(self, dof: str) -> tuple[float, complex] | None:
        """Newest frequency (Hz) and transmissibility of `dof`, None before the first."""

    def result(self) -> Estimate:
        """The estimate of all samples pushed so far; may be called at any time."""


ESTIMATORS: dict[str, type[Estimator]] = {
    'tracked_sine': TrackedSine,
    'stepped_sine': SteppedSine,
}

PARAMETERS = (
    Parameter(
        'analyzer.estimator',
        str,
        'tracked_sine',
        '',
        'how transmissibility is estimated; stepped_sine averages settled plateaus',
        choices=tuple(ESTIMATORS),
    ),
    *settings.PARAMETERS,
    *channels.PARAMETERS,
)

__all__ = [
    'ESTIMATORS',
    'PARAMETERS',
    'Estimator',
    'SteppedSine',
    'TrackedSine',
    'TrackedSineSettings',
]
