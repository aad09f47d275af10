"""The one thing every theory tool solves: a single degree of freedom, driven harmonically."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from qzs_rig.errors import InputError
from qzs_rig.mechanics.platform import Platform
from qzs_rig.mechanics.restoring.law import Design, RestoringLaw
from qzs_rig.mechanics.statics import equilibrium
from qzs_rig.parameters import RunSpec
from qzs_rig.units import DOFS, QUANTITIES


@dataclass(frozen=True)
class Oscillator:
    """w'' + 2 ζ w' + F(w) - load = Ĥ Ω^(2 - falloff) cos Ωτ, Eq (27) made nondimensional.

    The base moves as v = Ĥ Ω^-falloff cos Ωτ and the top as u = v + w: `falloff` 0, 1 and 2 hold
    the base displacement, velocity and acceleration constant over frequency (2 is also the plain
    forced oscillator under Ĥ cos Ωτ). w is in units of L20, rotations in rad; vertical is positive
    downward. τ is in units of 1/omega0. `load` is weight that the springs do not balance.
    `omega0` (rad/s) and `length` (m, or 1 rad) are those units in the run that it stands for.
    Numbers, and those of the design, are floats, or (n,) for n oscillators of one law at once.
    """

    law: RestoringLaw
    dof: str
    design: Design
    zeta: float
    amplitude: float
    load: float = 0.0
    falloff: int = 0
    omega0: float = 1.0
    length: float = 1.0

    def __post_init__(self) -> None:
        if self.dof not in DOFS:
            raise InputError(f'degree of freedom {self.dof!r} is unknown; give {", ".join(DOFS)}')
        if self.falloff not in (0, 1, 2):
            raise InputError(f'falloff is {self.falloff}; give 0, 1 or 2')
        for name in ('zeta', 'amplitude'):
            value = getattr(self, name)
            bad = np.flatnonzero(~((np.asarray(value) >= 0) & np.isfinite(value)))
            if bad.size:
                value = np.ravel(value)[bad[0]]
                raise InputError(f'{name} is {value}; theory needs a number 0 or more')

    @classmethod
    def of(cls, spec: RunSpec, dof: str, amplitude: float, falloff: int = 0) -> Oscillator:
        """The degree of freedom `dof` of a run's platform under base amplitude Ĥ."""
        platform = Platform.from_spec(spec)
        k = DOFS.index(dof) if dof in DOFS else 0
        return cls(
            law=platform.law,
            dof=dof,
            design=platform.design,
            zeta=platform.zeta[k],
            amplitude=amplitude,
            load=platform.load[k],
            falloff=falloff,
            omega0=platform.omega0[k],
            length=abs(platform.length[k]),
        )

    @classmethod
    def driven(cls, spec: RunSpec, dof: str) -> Oscillator:
        """The degree of freedom `dof` of a run's platform as the run's excitation drives it.

        Raises InputError where the base does not move in `dof`: how far it moves decides theory.
        """
        level = spec.number(f'excitation.amplitude.{dof}')
        if not level:
            raise InputError(
                f'excitation.amplitude.{dof} is 0: say how the base moves, for instance '
                f'--set excitation.quantity=acceleration --set excitation.amplitude.{dof}=4.0'
            )
        return cls.of(spec, dof, 0.0).under(level, spec.text('excitation.quantity'))

    def under(self, level: float, quantity: str) -> Oscillator:
        """The same on a base that holds an amplitude `level` of `quantity`, one of QUANTITIES, in
        m, m/s or m/s² (rad for rotations)."""
        falloff = QUANTITIES.index(quantity)
        amplitude = level / self.omega0**falloff / self.length
        return replace(self, amplitude=amplitude, falloff=falloff)

    @property
    def hertz(self) -> float:
        """Frequency in Hz at Ω = 1."""
        return self.omega0 / (2.0 * np.pi)

    def omega(self, frequency_hz: Any) -> Any:
        """Ω at frequencies in Hz, of any shape."""
        return 2.0 * np.pi * frequency_hz / self.omega0

    @cached_property
    def rest(self) -> float:
        """w at which the law holds `load`."""
        return equilibrium(self.law, self.design, self.load)

    @property
    def cubic(self) -> tuple[float, float]:
        """(c1, c3) of the odd part c1 w + c3 w³ of the law about `rest`."""
        return self.law.cubic(self.design, self.rest)[self.number]

    @property
    def number(self) -> int:
        """Place of the degree of freedom in DOFS."""
        return DOFS.index(self.dof)

    @property
    def domain(self) -> float:
        """The law holds for |w| below this."""
        return self.law.domain[self.number]

    def force(self, w: Any) -> Any:
        """F(w) - load at w of any shape, complex ones too."""
        return self.law.along(self.number)(self.design, w) - self.load

    def stiffness(self, w: Any) -> Any:
        """Slope of `force`."""
        return self.law.stiffness_along(self.number)(self.design, w)

    def drive(self, omega: Any) -> Any:
        """Amplitude of the right-hand side, Ĥ Ω^(2 - falloff)."""
        return self.amplitude * omega ** (2 - self.falloff)

    def base(self, omega: Any) -> Any:
        """Amplitude of v."""
        return self.amplitude * omega ** float(-self.falloff)
