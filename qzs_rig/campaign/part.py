"""What a chunk of points gave: columns, and why a row has no figures."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from qzs_rig.campaign.points import Points
from qzs_rig.errors import RigError
from qzs_rig.parameters import RunSpec
from qzs_rig.samples import Array

Codes = NDArray[np.int32]


class Part(NamedTuple):
    """Columns (n,) by name; `reasons[code[i]]` says why row i failed, '' (code 0) where it did
    not. A failed row is NaN."""

    columns: dict[str, Array]
    code: Codes
    reasons: tuple[str, ...]


class Harvest:
    """A Part being filled: all rows start as NaN without a reason."""

    def __init__(self, outputs: Iterable[str], rows: int) -> None:
        self._columns = {name: np.full(rows, np.nan) for name in outputs}
        self._code = np.zeros(rows, dtype=np.int32)
        self._reasons = ['']

    def put(self, rows: int | NDArray[np.int64], values: Mapping[str, Array | float]) -> None:
        """Figures of `rows` (numbers of rows)."""
        for name, value in values.items():
            self._columns[name][rows] = value

    def fail(self, rows: int | NDArray[np.int64], reason: str) -> None:
        """Why `rows` have no figures."""
        if np.size(rows) == 0:
            return
        if reason not in self._reasons:
            self._reasons.append(reason)
        self._code[rows] = self._reasons.index(reason)

    def part(self) -> Part:
        """What was gathered."""
        return Part(self._columns, self._code, tuple(self._reasons))


def row_by_row(
    points: Points,
    outputs: Iterable[str],
    function: Callable[[RunSpec, int], Mapping[str, float]],
) -> Part:
    """`function(spec, row)` at every point; a foreseen failure becomes the row's reason."""
    harvest = Harvest(outputs, len(points))
    for row in range(len(points)):
        try:
            harvest.put(row, function(points.spec(row), row))
        except (RigError, ArithmeticError, np.linalg.LinAlgError) as error:
            harvest.fail(row, f'{type(error).__name__}: {error}')
    return harvest.part()
