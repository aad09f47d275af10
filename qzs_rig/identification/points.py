"""What was measured, as the fit wants it: steady points of one degree of freedom."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import InputError
from qzs_rig.samples import Array
from qzs_rig.units import DOFS

Complex = NDArray[np.complex128]

LEAST = 4
"""Points a degree of freedom needs; fewer do not even show a curve."""


@dataclass(frozen=True)
class Points:
    """Measured transmissibility of `dof`; all arrays (n,), in the order of measurement.

    `phase` is top against base in rad, NaN where it was not measured; `std` the standard
    deviation of the magnitude, NaN where nobody gave one; `chirp` the rate of the sweep in Hz/s,
    signed, 0 for a settled point. `direction` is forward, reverse or none.
    """

    dof: str
    direction: NDArray[np.str_]
    frequency_hz: Array
    magnitude: Array
    phase: Array
    std: Array
    chirp: Array

    def __len__(self) -> int:
        return len(self.frequency_hz)

    def take(self, which: NDArray[np.bool_]) -> Points:
        """The points `which` (n,) says."""
        arrays = [getattr(self, item.name)[which] for item in fields(self)[1:]]
        return Points(self.dof, *arrays)

    @property
    def phased(self) -> NDArray[np.bool_]:
        """Which points have a phase."""
        return np.isfinite(self.phase)

    @property
    def weighted(self) -> bool:
        """Whether every point has a standard deviation."""
        return bool(np.isfinite(self.std).all())


def joined(parts: Sequence[Points]) -> Points:
    """The curves of one degree of freedom one after the other."""
    arrays = [
        np.concatenate([getattr(part, item.name) for part in parts]) for item in fields(Points)[1:]
    ]
    return Points(parts[0].dof, *arrays)


def by_dof(parts: Sequence[Points], dof: str | None) -> tuple[Points, ...]:
    """One Points a degree of freedom in the rig's order, or of `dof` alone.

    Raises InputError where there is nothing to fit.
    """
    there = [name for name in DOFS if any(part.dof == name for part in parts)]
    if dof is not None and dof not in there:
        raise InputError(
            f'there are no measured points of {dof!r}; measured: {", ".join(there) or "nothing"}'
        )
    chosen = [joined([p for p in parts if p.dof == name]) for name in there if dof in (None, name)]
    if not chosen:
        raise InputError('there are no measured points; is the base excited above its floor?')
    for points in chosen:
        _refuse_poor(points)
    return tuple(chosen)


def _refuse_poor(points: Points) -> None:
    if len(points) < LEAST:
        raise InputError(
            f'{points.dof} has {len(points)} usable points; a fit needs {LEAST} or more'
        )
    if np.ptp(points.frequency_hz) < 0.01 * points.frequency_hz.max():
        raise InputError(
            f'{points.dof} was measured at one frequency, {points.frequency_hz[0]:g} Hz; '
            'a fit needs a curve: sweep or step the frequency'
        )
    if np.ptp(np.log(points.magnitude)) < 1e-6:
        raise InputError(
            f'{points.dof} has the same transmissibility {points.magnitude[0]:g} at every '
            'frequency; that tells nothing of springs or damping'
        )
