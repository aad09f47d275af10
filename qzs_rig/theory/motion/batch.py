"""Many runs of one law side by side, each with its own damping, excitation, design and start."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from qzs_rig.errors import InputError
from qzs_rig.mechanics.platform import refuse_coupled_words
from qzs_rig.mechanics.restoring.law import Design, RestoringLaw
from qzs_rig.parameters import RunSpec
from qzs_rig.samples import Array
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import DOFS

WIDTH = 64
"""Runs that move together: loops over them turn into vector instructions."""

ZETA, DRIVE, OMEGA, LOAD, W, VELOCITY = range(6)
"""Rows of Batch.table."""

RATIOS = ('zeta', 'amplitude', 'omega', 'load')
"""Vary alone: everything else nondimensional stays."""

SLANT = 'L20'
"""Length of the suspension springs with L1/L20 held, so that a stays; L0 is held in m."""


@dataclass(frozen=True)
class Batch:
    """n runs of Eq (27) made nondimensional (see Oscillator).

    `design` (., n) has the numbers of Design in rows; the others are (n,): damping ratio, base
    amplitude Ĥ, frequency Ω > 0, unbalanced load, and relative motion and velocity dw/dτ at τ = 0,
    where the base is at its highest.
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
        w: ArrayLike = 0.0,
        velocity: ArrayLike = 0.0,
        **varied: Any,
    ) -> Batch:
        """Runs of `oscillator`, or of each of its columns, at `omega` with what is given `varied`,
        broadcast to (n,).

        The default starts at rest. Raises InputError for a number that is not finite or out of
        range, naming it.
        """
        own: Any = replace(oscillator, **varied)
        chosen = {'zeta': own.zeta, 'amplitude': own.amplitude, 'load': own.load}
        chosen |= {'omega': omega, 'w': w, 'velocity': velocity}
        values = {name: np.asarray(value, dtype=np.float64) for name, value in chosen.items()}
        try:
            n = np.broadcast_shapes((1,), *(np.shape(x) for x in (*values.values(), *own.design)))
        except ValueError:
            sizes = ', '.join(f'{k} {v.size}' for k, v in values.items())
            raise InputError(f'runs of different number: {sizes}; give each one or n') from None
        columns = {name: np.array(np.broadcast_to(x, n)) for name, x in values.items()}
        _check(columns)
        design = np.stack([np.broadcast_to(ratio, n) for ratio in own.design])
        return cls(own.law, own.dof, own.falloff, design, **columns)

    def __len__(self) -> int:
        return len(self.zeta)

    def __getitem__(self, which: Any) -> Batch:
        """The runs of a slice, a mask or indices."""
        names = ('zeta', 'amplitude', 'omega', 'load', 'w', 'velocity')
        picked = {name: getattr(self, name)[which] for name in names}
        return replace(self, design=self.design[:, which], **picked)

    def starting(self, w: ArrayLike, velocity: ArrayLike) -> Batch:
        """The same runs from another start."""
        shape = self.zeta.shape
        return replace(
            self,
            w=np.array(np.broadcast_to(w, shape), dtype=np.float64),
            velocity=np.array(np.broadcast_to(velocity, shape), dtype=np.float64),
        )

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
        """(6, n) what the kernels read, in the order of ZETA … VELOCITY."""
        return np.stack((self.zeta, self.drive, self.omega, self.load, self.w, self.velocity))

    @property
    def numbers(self) -> Array:
        """(count, n) what the compiled force takes, see RestoringLaw."""
        rows = self.law.numbers(Design(self.design), self.number)
        return np.stack([np.broadcast_to(row, len(self)) for row in rows])


def _check(columns: dict[str, Array]) -> None:
    for name, values in columns.items():
        good = np.isfinite(values)
        if name == 'omega':
            good &= values > 0.0
        if not good.all():
            wanted = 'a number above 0' if name == 'omega' else 'a finite number'
            raise InputError(f'{name} is {values[~good][0]}; a run needs {wanted}')


def batch_along(
    spec: RunSpec, oscillator: Oscillator, omega: float, name: str, values: Array
) -> Batch:
    """A run of `oscillator`, the one of `spec`, at `omega` for each of `values` of `name`.

    RATIOS replace their own. `L20` or any `platform.…` word changes the platform: springs, base
    amplitude in m and frequency in rad/s stay what they are, and all ratios follow, damping too
    unless `platform.zeta` fixes it.
    """
    if name in RATIOS:
        varied: dict[str, Any] = {'omega': omega} | {name: values}
        return Batch.of(oscillator, **varied)
    word = 'platform.L20' if name == SLANT else name
    if not word.startswith('platform.'):
        raise InputError(
            f'unknown parameter {name!r}; vary one of {", ".join(RATIOS)}, {SLANT} or '
            'platform.…, which qzs-rig scenarios --parameters lists'
        )
    own = Oscillator.of(spec, oscillator.dof, oscillator.amplitude)
    held = {'platform.L1_hat': own.design.L1} if name == SLANT else {}
    columns = spec.override(held).columns({word: values})
    refuse_coupled_words(columns)
    rigs = Oscillator.of(columns, oscillator.dof, oscillator.amplitude)
    return Batch.of(
        replace(rigs, falloff=oscillator.falloff),
        omega * own.omega0 / rigs.omega0,
        amplitude=oscillator.amplitude * own.length / rigs.length,
    )
