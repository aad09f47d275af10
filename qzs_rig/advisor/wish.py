"""What a user wants of a platform."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from qzs_rig.errors import InputError

HELD = {'displacement': 0, 'velocity': 1, 'acceleration': 2}
"""What the base holds constant over frequency; its amplitude falls as omega^-HELD."""


@dataclass(frozen=True)
class Wish:
    """Payload (kg), onset (Hz) above which T < 1, stroke (m, relative motion to either side that
    the platform may use), amplitude of the base in the unit of `held`, damping ratio."""

    mass: float
    onset: float
    stroke: float
    level: float
    held: str = 'acceleration'
    zeta: float = 0.1

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            name = self.held if item.name == 'level' and self.held == 'displacement' else item.name
            if item.name != 'held' and not (value > 0.0 and math.isfinite(value)):
                raise InputError(f'--{name} {value:g} must be a number above 0')
        if not self.zeta <= 1.0:
            raise InputError(
                f'--zeta {self.zeta:g} is beyond critical damping, where nothing isolates; '
                'give 1 or less'
            )
        if self.held not in HELD:
            raise InputError(f'held is {self.held!r}; known: {", ".join(HELD)}')
        if self.held == 'displacement' and not self.stroke > self.level:
            raise InputError(
                f'--stroke {self.stroke:g} m is no more than --displacement {self.level:g} m, yet '
                'an isolated plate stands still and moves against the base by all of it; '
                'allow more --stroke'
            )
