"""What a campaign computes at each point."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from qzs_rig.campaign.axes import Column
from qzs_rig.errors import RigError
from qzs_rig.parameters import Parameter, RunSpec, Value
from qzs_rig.samples import Array


@dataclass(frozen=True)
class Points:
    """`count` points of a campaign, the first of which is its point number `first`.

    `fixed` holds what all share, with some value of each varied parameter in it, so that asking
    whether a parameter is set has one answer; `varied` its columns (count,).
    """

    fixed: RunSpec
    varied: Mapping[str, Column]
    first: int
    count: int
    seed: int

    def __len__(self) -> int:
        return self.count

    def columns(self, rows: NDArray[np.int64]) -> RunSpec:
        """`rows` as one spec, whose varied numbers are columns; words are those of `fixed`."""
        numbers = {n: c for n, c in self.varied.items() if c.dtype.kind == 'f'}
        return self.fixed.columns({name: column[rows] for name, column in numbers.items()})

    def alike(self, rows: NDArray[np.int64]) -> Iterator[tuple[NDArray[np.int64], RunSpec]]:
        """`rows` in groups that share all words and flags, in order of appearance, each with its
        `columns`."""
        words = {n: c for n, c in self.varied.items() if c.dtype.kind in 'Ub'}
        kind = np.zeros(len(rows), dtype=np.int64)
        for column in words.values():
            values, place = np.unique(column[rows], return_inverse=True)
            kind = kind * len(values) + place
        for first in np.sort(np.unique(kind, return_index=True)[1]).tolist():
            same = rows[kind == kind[first]]
            shared = {name: column[same[0]].item() for name, column in words.items()}
            yield same, self.columns(same).override(shared)

    def spec(self, row: int) -> RunSpec:
        """Every parameter of one point; `row` counts from 0 within these points."""
        values: dict[str, Value] = {n: column[row].item() for n, column in self.varied.items()}
        return self.fixed.override(values)

    def point_seed(self, row: int) -> int:
        """A seed for this point alone, from the campaign's seed and the point's number."""
        return int(np.random.SeedSequence([self.seed, self.first + row]).generate_state(1)[0] >> 1)


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


@dataclass(frozen=True)
class Output:
    """A column of the result."""

    name: str
    unit: str
    text: str


Compute = Callable[[Points, RunSpec, Harvest], None]
"""Puts the figures of points, under the options of a task, into the harvest."""


@dataclass(frozen=True)
class Task:
    """`evaluate(points, options)` gives the `outputs` of a chunk, wherever and in whatever order
    chunks are computed: it depends on the points alone.

    `inputs` are what a point has beside the parameters of a run; of each group in `needed` one
    has to be fixed or varied. `chunk` points take about a second or less; a kernel moves `block`
    of them together.
    """

    name: str
    text: str
    inputs: tuple[Parameter, ...]
    needed: tuple[tuple[str, ...], ...]
    options: tuple[Parameter, ...]
    outputs: tuple[Output, ...]
    chunk: int
    compute: Compute
    block: int = 1

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the outputs."""
        return tuple(output.name for output in self.outputs)

    def evaluate(self, points: Points, options: RunSpec) -> Part:
        """The figures of `points`; a row that failed is NaN with a reason, not a warning."""
        harvest = Harvest(self.columns, len(points))
        with np.errstate(all='ignore'):
            self.compute(points, options, harvest)
        return harvest.part()


def row_by_row(function: Callable[[RunSpec, RunSpec, int], Mapping[str, float]]) -> Compute:
    """Each point by itself: `function(spec, options, seed)` with a seed of the point's own; a
    foreseen failure becomes the row's reason."""

    def compute(points: Points, options: RunSpec, harvest: Harvest) -> None:
        for row in range(len(points)):
            try:
                harvest.put(row, function(points.spec(row), options, points.point_seed(row)))
            except (RigError, ArithmeticError, np.linalg.LinAlgError) as error:
                harvest.fail(row, f'{type(error).__name__}: {error}')

    return compute
