"""Many runs of one law side by side, each with its own damping, excitation, design and start."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from qzs_rig.errors import InputError
from qzs_rig.mechanics.design import Design
from qzs_rig.mechanics.platform import Platform
from qzs_rig.mechanics.restoring.law import RestoringLaw
from qzs_rig.parameters import RunSpec
from qzs_rig.samples import Array
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import DOFS, TRANSLATIONS

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

    `design` is (6, n); the others are (n,): damping ratio, base amplitude Ĥ, frequency Ω > 0,
    unbalanced load, and relative motion and velocity dw/dτ at τ = 0, where the base is at its
    highest.
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
    ) -> Batch:
        """Runs of `oscillator` at `omega` with what is given varied, broadcast to (n,).

        `designs` (n) replace the oscillator's. The default starts at rest. Raises InputError for
        a number that is not finite or out of range, naming it.
        """
        own = {'zeta': oscillator.zeta, 'amplitude': oscillator.amplitude, 'load': oscillator.load}
        varied = {'zeta': zeta, 'amplitude': amplitude, 'load': load}
        chosen = {name: own[name] if given is None else given for name, given in varied.items()}
        chosen |= {'omega': omega, 'w': w, 'velocity': velocity}
        values = {name: np.asarray(value, dtype=np.float64) for name, value in chosen.items()}
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
        each = np.transpose([oscillator.design] if designs is None else designs)
        design = np.broadcast_to(each, (len(each), len(columns['omega'])))
        return cls(oscillator.law, oscillator.dof, oscillator.falloff, design, **columns)

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
        """(6, n) what the compiled force reads: the design, or a cubic law's three coefficients."""
        if not self.law.cubic_only:
            return np.array(self.design, order='C')
        numbers = np.zeros(self.design.shape)
        for row, coefficient in enumerate(self.law.taylor(Design(*self.design))[self.number]):
            numbers[row] = coefficient
        return numbers


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


def batch_along(
    spec: RunSpec, oscillator: Oscillator, omega: float, name: str, values: Array
) -> Batch:
    """A run of `oscillator`, the one of `spec`, at `omega` for each of `values` of `name`.

    RATIOS replace their own. `L20` or any `platform.…` word changes the platform: springs, base
    amplitude in m and frequency in rad/s stay what they are, and all ratios follow.
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
    k = DOFS.index(oscillator.dof)
    own = Platform.from_spec(spec)
    held = {'platform.L1_hat': own.design.L1} if name == SLANT else {}
    rigs = [Platform.from_spec(spec.override({**held, word: v})) for v in values.tolist()]
    reach = oscillator.dof in TRANSLATIONS
    scale = np.array([own.length[k] / rig.length[k] if reach else 1.0 for rig in rigs])
    speed = np.array([own.omega0[k] / rig.omega0[k] for rig in rigs])
    # a damping ratio of one's own stays; the platform's follows the platform
    own_zeta = not math.isclose(oscillator.zeta, own.zeta[k], rel_tol=1e-12)
    return Batch.of(
        oscillator,
        omega * speed,
        zeta=oscillator.zeta if own_zeta else np.array([rig.zeta[k] for rig in rigs]),
        amplitude=oscillator.amplitude * scale,
        load=np.array([rig.load[k] for rig in rigs]),
        designs=[rig.design for rig in rigs],
    )
