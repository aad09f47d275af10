"""From the numbers of the theory to those of the rig: one degree of freedom of one run."""

from __future__ import annotations

import math
from dataclasses import dataclass

from qzs_rig.excitation import QUANTITIES
from qzs_rig.excitation.sweep import band
from qzs_rig.mechanics.platform import Platform
from qzs_rig.parameters import RunSpec
from qzs_rig.units import DOFS

MARGIN = 1.02
"""Theory goes a little beyond the band of the run."""


@dataclass(frozen=True)
class Scale:
    """Ω = 2πf/omega0 (rad/s), w = length ŵ (m, or 1 rad); the base moves Ĥ Ω^-falloff times
    length, Ĥ being `amplitude`; `low_hz` to `high_hz` is the range to predict."""

    dof: str
    omega0: float
    length: float
    amplitude: float
    falloff: int
    low_hz: float
    high_hz: float

    @classmethod
    def of(cls, spec: RunSpec, platform: Platform, dof: str) -> Scale:
        """The scale of `dof` in a run on `platform`."""
        k = DOFS.index(dof)
        omega0, length = platform.omega0[k], abs(platform.length[k])
        falloff = QUANTITIES.index(spec.text('excitation.quantity'))
        held = spec.number(f'excitation.amplitude.{dof}')
        low, high = _range(spec)
        return cls(
            dof, omega0, length, held / omega0**falloff / length, falloff, low / MARGIN,
            high * MARGIN,
        )  # fmt: skip

    def omega(self, frequency_hz: float) -> float:
        """Ω at a frequency."""
        return 2.0 * math.pi * frequency_hz / self.omega0

    @property
    def hertz(self) -> float:
        """Frequency at Ω = 1."""
        return self.omega0 / (2.0 * math.pi)


def _range(spec: RunSpec) -> tuple[float, float]:
    if spec.text('excitation.kind') == 'sine':
        f = spec.number('excitation.frequency')
        return 0.5 * f, 2.0 * f
    return band(spec)
