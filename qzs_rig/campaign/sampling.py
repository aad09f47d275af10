"""Where the points lie: a grid, or a Latin hypercube. Any part of it can be had by itself."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from qzs_rig.campaign.axes import Axis, Column
from qzs_rig.errors import InputError
from qzs_rig.samples import Array

PLACES = ('centre', 'random', 'maximin')
METHOD = 'scipy.stats.qmc.LatinHypercube'
"""Part of the plan: points drawn by another method belong to another campaign."""
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
        """'grid of 3 x 4': the sizes of the axes."""
        return f'grid of {" x ".join(str(size) for size in self.shape)}'


@dataclass(frozen=True)
class LatinHypercube:
    """`points` samples; along each axis every one of `points` equal strata is hit once.

    McKay, Beckman, Conover, Technometrics 21 (1979) 239. `place` says where in its stratum a
    sample lies: in the centre or at random; `maximin` is the best of CANDIDATES centred ones
    (Johnson, Moore, Ylvisaker, J. Stat. Plan. Inference 26 (1990) 131). All are drawn at once, the
    same from the same seed: a chunk is a slice.
    """

    axes: tuple[Axis, ...]
    points: int
    seed: int
    place: str = 'centre'

    def __post_init__(self) -> None:
        if self.place == 'maximin' and self.points > MAXIMIN_MOST:
            raise InputError(
                f'campaign: maximin compares all distances, up to {MAXIMIN_MOST} samples; '
                f'{self.points} are asked for: use place: centre'
            )

    def column(self, number: int, first: int, stop: int) -> Column:
        """Values of axis `number` at points first … stop - 1."""
        # rounding may take the highest sample to 1, outside its stratum
        return self.axes[number].at(np.minimum(self._unit[number, first:stop], 1.0 - 2.0**-53))

    def to_document(self) -> dict[str, Any]:
        """As in the plan's YAML."""
        return {
            'sample': 'latin_hypercube',
            'samples': self.points,
            'place': self.place,
            'method': METHOD,
        }

    @property
    def text(self) -> str:
        """'Latin hypercube over 2 axes (random)': number of axes, place within strata."""
        return f'Latin hypercube over {len(self.axes)} axes ({self.place})'

    @cached_property
    def _unit(self) -> Array:
        """The samples (axes, points) in the unit cube."""
        from scipy.stats import qmc  # takes most of a second to import

        source = np.random.default_rng(self.seed)
        engine = qmc.LatinHypercube(len(self.axes), scramble=self.place == 'random', seed=source)
        sample = engine.random(self.points)
        if self.place == 'maximin' and self.points > 1:
            others = (engine.random(self.points) for _ in range(CANDIDATES - 1))
            sample = max((sample, *others), key=_closest)
        return np.ascontiguousarray(sample.T)


def _closest(sample: Array) -> float:
    """Squared distance of the closest two of the samples (n, axes)."""
    from scipy.spatial.distance import pdist

    return float(pdist(sample, 'sqeuclidean').min())


Sample = Grid | LatinHypercube


def columns(sample: Sample, first: int, stop: int) -> Mapping[str, Column]:
    """All axes by name at points first … stop - 1."""
    return {
        axis.parameter.name: sample.column(number, first, stop)
        for number, axis in enumerate(sample.axes)
    }
