"""Many runs of one law side by side, each with its own damping, excitation, design and start."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from qzs_rig.errors import InputError
from qzs_rig.mechanics.design import Design
from qzs_rig.mechanics.restoring.law import RestoringLaw
from qzs_rig.samples import Array
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import DOFS


@dataclass(frozen=True)
class Lanes:
    """n runs of Eq (27) made nondimensional (see Oscillator).

    `design` is (6,), one for all, or (6, n); the others are (n,): damping ratio, base amplitude Ĥ,
    frequency Ω > 0, unbalanced load, and relative motion and velocity dw/dτ at τ = 0, where the
    base is at its highest.
    """

    law: RestoringLaw
    dof: str
    falloff: int
    design: Array
    zeta: Array
    amplitude: Array
    omega: Array
    load: Array
    w: Array
    velocity: Array

    @classmethod
    def of(
        cls,
        oscillator: Oscillator,
        omega: ArrayLike,
        *,
        zeta: ArrayLike | None = None,
        amplitude: ArrayLike | None = None,
        load: ArrayLike | None = None,
        designs: Sequence[Design] | None = None,
        w: ArrayLike = 0.0,
        velocity: ArrayLike = 0.0,
    ) -> Lanes:
        """Runs of `oscillator` at `omega` with what is given varied, broadcast to (n,).

        `designs` (n) replace the oscillator's. The default starts at rest. Raises InputError for
        a number that is not finite or out of range, naming it.
        """
        own = {'zeta': oscillator.zeta, 'amplitude': oscillator.amplitude, 'load': oscillator.load}
        varied = {'zeta': zeta, 'amplitude': amplitude, 'load': load}
        told = {name: own[name] if given is None else given for name, given in varied.items()}
        told |= {'omega': omega, 'w': w, 'velocity': velocity}
        values = {name: np.asarray(value, dtype=np.float64) for name, value in told.items()}
        count = np.zeros(1 if designs is None else len(designs))
        try:
            *lines, _ = np.broadcast_arrays(*values.values(), count)
        except ValueError:
            sizes = ', '.join(f'{k} {v.size}' for k, v in values.items())
            raise InputError(f'runs of different number: {sizes}; give each one or n') from None
        columns = {
            name: np.ascontiguousarray(line) for name, line in zip(values, lines, strict=True)
        }
        _check(columns)
        design = oscillator.design if designs is None else np.transpose(designs)
        return cls(
            oscillator.law,
            oscillator.dof,
            oscillator.falloff,
            np.ascontiguousarray(design, dtype=np.float64),
            **columns,
        )

    def __len__(self) -> int:
        return len(self.zeta)

    def __getitem__(self, which: Any) -> Lanes:
        """The runs of a slice, a mask or indices."""
        names = ('zeta', 'amplitude', 'omega', 'load', 'w', 'velocity')
        design = self.design if self.shared else np.ascontiguousarray(self.design[:, which])
        return replace(self, design=design, **{name: getattr(self, name)[which] for name in names})

    def starting(self, w: ArrayLike, velocity: ArrayLike) -> Lanes:
        """The same runs from another start."""
        shape = self.zeta.shape
        return replace(
            self,
            w=np.array(np.broadcast_to(w, shape), dtype=np.float64),
            velocity=np.array(np.broadcast_to(velocity, shape), dtype=np.float64),
        )

    @property
    def shared(self) -> bool:
        """Have all runs the same design?"""
        return self.design.ndim == 1

    @property
    def number(self) -> int:
        """Place of the degree of freedom in DOFS."""
        return DOFS.index(self.dof)

    @property
    def drive(self) -> Array:
        """(n,) amplitude of the right-hand side, Ĥ Ω^(2 - falloff)."""
        return np.asarray(self.amplitude * self.omega ** (2 - self.falloff))

    @property
    def base(self) -> Array:
        """(n,) amplitude of the base motion v."""
        return np.asarray(self.amplitude * self.omega ** float(-self.falloff))

    @property
    def table(self) -> Array:
        """(6, n) what the kernels read: zeta, drive, omega, load, w, w'."""
        rows = (self.zeta, self.drive, self.omega, self.load, self.w, self.velocity)
        return np.ascontiguousarray(np.stack(rows))


def _check(columns: dict[str, Array]) -> None:
    for name, values in columns.items():
        good = np.isfinite(values)
        if name in ('zeta', 'amplitude'):
            good &= values >= 0.0
        if name == 'omega':
            good &= values > 0.0
        if not good.all():
            wanted = {'omega': 'a number above 0', 'zeta': 'a number 0 or more'}
            wanted['amplitude'] = wanted['zeta']
            first = values[np.flatnonzero(~good)[0]]
            raise InputError(
                f'{name} is {first}; a run needs {wanted.get(name, "a finite number")}'
            )
