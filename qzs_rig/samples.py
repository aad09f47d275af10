"""Stamped, named and dimensioned pieces of a signal: the one currency between stages."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import GapError
from qzs_rig.units import DOFS, displacement_unit

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]
NS = 1_000_000_000


@dataclass(frozen=True)
class Channel:
    """Name and unit of one column."""

    name: str
    unit: str


MOTION_CHANNELS = tuple(
    Channel(f'{dof}.{quantity}', displacement_unit(dof) + per)
    for quantity, per in (('position', ''), ('velocity', '/s'), ('acceleration', '/s²'))
    for dof in DOFS
)
"""Motion of a plate in the four degrees of freedom."""

IMU_CHANNELS = (
    *(Channel(f'angular_velocity.{axis}', 'rad/s') for axis in 'xyz'),
    *(Channel(f'linear_acceleration.{axis}', 'm/s²') for axis in 'xyz'),
)
"""Readings of an inertial sensor, in its own frame (REP 145)."""


@dataclass(frozen=True)
class Samples:
    """Rows `data` (n, c) float64 of `channels` (c), taken at `stamps_ns` (n,) int64.

    The rig's own stamps are exact: start_ns + k * step_ns of its run. A driver's are what it says.
    """

    stamps_ns: Stamps
    data: Array
    channels: tuple[Channel, ...]

    def __post_init__(self) -> None:
        if self.data.shape != (len(self.stamps_ns), len(self.channels)):
            raise ValueError(
                f'data {self.data.shape} does not fit {len(self.stamps_ns)} stamps and '
                f'{len(self.channels)} channels'
            )

    def __len__(self) -> int:
        return len(self.stamps_ns)

    def __getitem__(self, part: slice) -> Samples:
        """Some of the samples, as a view."""
        return Samples(self.stamps_ns[part], self.data[part], self.channels)


def index_of(stamp_ns: int, start_ns: int, step_ns: int) -> int:
    """Sample index of a stamp on the grid; raises GapError for a stamp that is not on it."""
    index, remainder = divmod(stamp_ns - start_ns, step_ns)
    if remainder:
        raise GapError(
            f'stamp {stamp_ns} ns lies {remainder} ns off the {step_ns} ns sample grid '
            f'from {start_ns} ns; give all nodes the same run.rate'
        )
    return index
