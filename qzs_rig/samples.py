"""A uniformly sampled, named and dimensioned piece of a signal: the currency between stages."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import GapError

Array = NDArray[np.float64]
NS = 1_000_000_000


@dataclass(frozen=True)
class Channel:
    """Name and unit of one column."""

    name: str
    unit: str


@dataclass(frozen=True)
class TimeHistory:
    """Samples `data` (n, c) float64; sample k was taken at exactly `start_ns + k * step_ns`."""

    start_ns: int
    step_ns: int
    channels: tuple[Channel, ...]
    data: Array

    def __post_init__(self) -> None:
        if self.data.ndim != 2 or self.data.shape[1] != len(self.channels):
            raise ValueError(f'data {self.data.shape} does not fit {len(self.channels)} channels')

    def __len__(self) -> int:
        return int(self.data.shape[0])

    @property
    def end_ns(self) -> int:
        """Stamp of the sample after the last one."""
        return self.start_ns + len(self) * self.step_ns

    def stamps_ns(self) -> NDArray[np.int64]:
        """Stamps of all samples, (n,) int64."""
        return self.start_ns + np.arange(len(self), dtype=np.int64) * self.step_ns

    def slice(self, first: int, last: int) -> TimeHistory:
        """Samples `first` to `last` (excluded), as a view."""
        return TimeHistory(
            self.start_ns + first * self.step_ns,
            self.step_ns,
            self.channels,
            self.data[first:last],
        )


def join(pieces: Sequence[TimeHistory]) -> TimeHistory:
    """One contiguous history of `pieces`; raises GapError where one does not follow the last."""
    first = pieces[0]
    samples = 0
    for piece in pieces:
        expected = first.start_ns + samples * first.step_ns
        if piece.step_ns != first.step_ns or piece.channels != first.channels:
            raise ValueError('pieces of one history share the step and the channels')
        if piece.start_ns != expected:
            jump_ms = (piece.start_ns - expected) / 1e6
            raise GapError(
                f'time history jumped by {jump_ms:.3f} ms after sample {samples - 1}; '
                'raise the QoS depth or lower the rate'
            )
        samples += len(piece)
    return TimeHistory(
        first.start_ns,
        first.step_ns,
        first.channels,
        np.concatenate([piece.data for piece in pieces]),
    )


def index_of(stamp_ns: int, start_ns: int, step_ns: int) -> int:
    """Sample index of a stamp on the grid; raises GapError for a stamp that is not on it."""
    index, remainder = divmod(stamp_ns - start_ns, step_ns)
    if remainder:
        raise GapError(
            f'stamp {stamp_ns} ns lies {remainder} ns off the {step_ns} ns sample grid '
            f'from {start_ns} ns; give all nodes the same run.rate'
        )
    return index
