"""Where the points lie: a grid, or a Latin hypercube. Any part of it can be had by itself."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from qzs_rig.campaign.axes import Axis, Column
from qzs_rig.errors import InputError
from qzs_rig.samples import Array

PLACES = ('centre', 'random', 'maximin')
CANDIDATES = 20
"""Hypercubes of which `maximin` takes the one whose closest two points are farthest apart."""
MAXIMIN_MOST = 2000
"""Samples up to which all distances are compared."""


@dataclass(frozen=True)
class Grid:
    """Every combination of the axes' values; the last axis runs fastest."""

    axes: tuple[Axis, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """Values of each axis."""
        return tuple(len(axis.values) for axis in self.axes)

    @property
    def points(self) -> int:
        """How many points there are."""
        return math.prod(self.shape)

    def column(self, number: int, first: int, stop: int) -> Column:
        """Values of axis `number` at points first … stop - 1."""
        size, stride = self.shape[number], math.prod(self.shape[number + 1 :])
        return self.axes[number].values[np.arange(first, stop) // stride % size]

    def to_document(self) -> dict[str, Any]:
        """As in the plan's YAML."""
        return {'sample': 'grid'}

    @property
    def text(self) -> str:
        """In words."""
        return f'grid of {" x ".join(str(size) for size in self.shape)}'


@dataclass(frozen=True)
class LatinHypercube:
    """`points` samples; along each axis every one of `points` equal strata is hit once.

    McKay, Beckman, Conover, Technometrics 21 (1979) 239. `place` says where in its stratum a
    sample lies: in the centre or at random; `maximin` is the best of CANDIDATES centred ones
    (Johnson, Moore, Ylvisaker, J. Stat. Plan. Inference 26 (1990) 131).
    """

    axes: tuple[Axis, ...]
    points: int
    seed: int
    place: str

    def column(self, number: int, first: int, stop: int) -> Column:
        """Values of axis `number` at points first … stop - 1."""
        within = self._offset(number, first, stop)
        u = (self._strata[number][first:stop] + within) / self.points
        # the division may round up to the next stratum, at most to 1
        return self.axes[number].at(np.minimum(u, 1.0 - 2.0**-53))

    def to_document(self) -> dict[str, Any]:
        """As in the plan's YAML."""
        return {'sample': 'latin_hypercube', 'samples': self.points, 'place': self.place}

    @property
    def text(self) -> str:
        """In words."""
        return f'Latin hypercube over {len(self.axes)} axes ({self.place})'

    @cached_property
    def _strata(self) -> list[NDArray[np.int64]]:
        sets = range(CANDIDATES if self.place == 'maximin' else 1)
        return max((self._candidate(k) for k in sets), key=self._closest)

    def _candidate(self, k: int) -> list[NDArray[np.int64]]:
        return [
            np.random.default_rng([self.seed, number, k]).permutation(self.points)
            for number in range(len(self.axes))
        ]

    def _closest(self, strata: list[NDArray[np.int64]]) -> int:
        """Squared distance of the closest two samples, in strata; 0 where nobody asks."""
        if self.place != 'maximin' or self.points < 2:
            return 0
        distance = sum((s[:, None] - s[None, :]) ** 2 for s in strata)
        return int(np.min(distance + np.diag(np.full(self.points, np.iinfo(np.int32).max))))

    def _offset(self, number: int, first: int, stop: int) -> float | Array:
        if self.place != 'random':
            return 0.5
        # one step of the generator a number: a part of the sequence needs no more than a leap
        source = np.random.PCG64([self.seed, number, CANDIDATES]).advance(first)
        return np.random.Generator(source).random(stop - first)


Sample = Grid | LatinHypercube


def latin_hypercube(axes: tuple[Axis, ...], points: int, seed: int, place: str) -> LatinHypercube:
    """A checked LatinHypercube; raises InputError."""
    if place not in PLACES:
        raise InputError(f'campaign: place {place!r} is unknown; give one of {", ".join(PLACES)}')
    if place == 'maximin' and points > MAXIMIN_MOST:
        raise InputError(
            f'campaign: maximin compares all distances, up to {MAXIMIN_MOST} samples; {points} '
            'are asked for: use place: centre'
        )
    return LatinHypercube(axes, points, seed, place)


def columns(sample: Sample, first: int, stop: int) -> Mapping[str, Column]:
    """All axes by name at points first … stop - 1."""
    return {
        axis.parameter.name: sample.column(number, first, stop)
        for number, axis in enumerate(sample.axes)
    }
