"""The recent samples of base and top, contiguous, addressed by their index since sample 0."""

from __future__ import annotations

import numpy as np

from qzs_rig.samples import Array


class SampleBuffer:
    """Keeps the samples [start, end); the owner forgets what it no longer needs."""

    def __init__(self, columns: int, capacity: int) -> None:
        """Room for `capacity` samples that are not forgotten yet."""
        self._data = np.empty((columns, 2, 2 * capacity))
        self._origin = 0
        self.start = 0
        self.end = 0

    @property
    def room(self) -> int:
        """Samples that can be appended now."""
        return self._data.shape[2] - (self.end - self.start)

    def append(self, base: Array, top: Array) -> None:
        """Copy `base`, `top` (n, columns) behind the last sample; n must not exceed `room`."""
        n = base.shape[0]
        if self.end + n - self._origin > self._data.shape[2]:
            self._compact()
        place = slice(self.end - self._origin, self.end - self._origin + n)
        self._data[:, 0, place] = base.T
        self._data[:, 1, place] = top.T
        self.end += n

    def forget(self, before: int) -> None:
        """Release the samples before index `before`."""
        self.start = max(self.start, min(before, self.end))

    def window(self, column: int, first: int, last: int) -> Array:
        """Base and top of `column` over [first, last), (2, last - first), a view."""
        return self._data[column, :, first - self._origin : last - self._origin]

    def _compact(self) -> None:
        kept = self._data[:, :, self.start - self._origin : self.end - self._origin].copy()
        self._data[:, :, : kept.shape[2]] = kept
        self._origin = self.start
