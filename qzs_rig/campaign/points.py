"""The points of one chunk: what is fixed, and a column for what varies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from qzs_rig.campaign.axes import Column
from qzs_rig.parameters import RunSpec, Value
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

    def has(self, name: str) -> bool:
        """Is the parameter set, by default, base or vary?"""
        return name in self.fixed

    def number(self, name: str) -> Array:
        """(count,) of a numeric parameter."""
        value: Any = self.varied.get(name, self.fixed[name])
        return np.broadcast_to(np.asarray(value, dtype=np.float64), (self.count,))

    def word(self, name: str) -> NDArray[np.str_]:
        """(count,) of a text parameter."""
        value: Any = self.varied.get(name, self.fixed[name])
        return np.broadcast_to(np.asarray(value), (self.count,))

    def spec(self, row: int) -> RunSpec:
        """Every parameter of one point; `row` counts from 0 within these points."""
        values: dict[str, Value] = {n: column[row].item() for n, column in self.varied.items()}
        return self.fixed.override(values)

    def point_seed(self, row: int) -> int:
        """A seed for this point alone, from the campaign's seed and the point's number."""
        return int(np.random.SeedSequence([self.seed, self.first + row]).generate_state(1)[0] >> 1)
