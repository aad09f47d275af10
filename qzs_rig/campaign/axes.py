"""One dimension of a campaign: listed values, or a range between two ends."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import InputError
from qzs_rig.parameters import Parameter, Value, closest
from qzs_rig.samples import Array

Column = NDArray[Any]
"""One value a point: numbers, words or yes/no."""

SCALES = ('linear', 'log')
MOST = 10_000_000
"""Values of one range, and samples of a hypercube: both are kept in memory."""


@dataclass(frozen=True)
class Listed:
    """Values as they were given, in that order."""

    parameter: Parameter
    given: tuple[Value, ...]

    @cached_property
    def values(self) -> Column:
        """(size,), what a grid takes."""
        return np.array(self.given)

    def at(self, u: Array) -> Column:
        """Values at places u (n,) in [0, 1): each has an equal share."""
        return self.values[(u * len(self.given)).astype(np.int64)]

    def to_document(self) -> Any:
        """As in the plan's YAML."""
        return list(self.given)

    @property
    def text(self) -> str:
        """The axis in words."""
        return ', '.join(str(value) for value in self.given)


@dataclass(frozen=True)
class Range:
    """From `low` to `high`, evenly spaced or by equal ratios; `count` values in a grid."""

    parameter: Parameter
    low: float
    high: float
    scale: str
    count: int | None

    @cached_property
    def values(self) -> Column:
        """(count,), both ends included."""
        assert self.count is not None
        space = np.geomspace if self.scale == 'log' else np.linspace
        return space(self.low, self.high, self.count)

    def at(self, u: Array) -> Column:
        """Values at places u (n,) in [0, 1) between the ends."""
        if self.scale == 'log':
            return np.asarray(self.low * (self.high / self.low) ** u)
        return np.asarray(self.low + (self.high - self.low) * u)

    def to_document(self) -> Any:
        """As in the plan's YAML."""
        count = {} if self.count is None else {'count': self.count}
        return {'from': self.low, 'to': self.high, **count, 'scale': self.scale}

    @property
    def text(self) -> str:
        """The axis in words."""
        return f'{self.low:g} … {self.high:g} ({self.scale})'


Axis = Listed | Range


def axis_of(parameter: Parameter, given: Any, grid: bool) -> Axis:
    """The axis that a plan's `vary` gives for `parameter`; raises InputError.

    Bounds are checked here, at every listed value and at both ends, so points need no check.
    """
    if isinstance(given, list):
        return _listed(parameter, given)
    if isinstance(given, dict):
        return _range(parameter, given, grid)
    raise InputError(
        f'vary {parameter.name}: {given!r} is no axis; give a list of values, or '
        '{from: …, to: …, count: …, scale: linear or log}; one value alone belongs under base'
    )


def _listed(parameter: Parameter, given: list[Any]) -> Listed:
    if not given:
        raise InputError(f'vary {parameter.name}: the list is empty; give at least one value')
    values = tuple(parameter.convert(value) for value in given)
    if len(set(values)) < len(values):
        raise InputError(f'vary {parameter.name}: a value is listed twice; keep one')
    return Listed(parameter, values)


def _range(parameter: Parameter, given: dict[str, Any], grid: bool) -> Range:
    name = f'vary {parameter.name}'
    refuse_unknown(given, ('from', 'to', 'scale', *(('count',) if grid else ())), name)
    if parameter.kind is not float:
        raise InputError(f'{name}: a range is for real numbers; list the values')
    missing = {'from', 'to', *(('count',) if grid else ())} - set(given)
    if missing:
        raise InputError(f'{name}: {", ".join(sorted(missing))} is missing')
    low, high = (float(parameter.convert(given[end])) for end in ('from', 'to'))
    scale = given.get('scale', 'linear')
    if scale not in SCALES:
        raise InputError(f'{name}: scale {scale!r} is unknown; give one of {", ".join(SCALES)}')
    if scale == 'log' and not low * high > 0.0:
        raise InputError(f'{name}: a log scale from {low:g} to {high:g} is none; use linear')
    return Range(parameter, low, high, scale, whole(name, given['count'], MOST) if grid else None)


def whole(name: str, value: Any, most: int, least: int = 1) -> int:
    """`value` as a whole number in least … most; raises InputError."""
    if isinstance(value, float) and value.is_integer():  # 1e6 with a point: YAML's 1.0e+6
        value = int(value)
    if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
        raise InputError(f'{name}: {value!r} must be a whole number from {least} to {most}')
    return value


def refuse_unknown(given: Mapping[str, Any], known: Iterable[str], where: str) -> None:
    """InputError for a key that is not `known`, with those that are."""
    known = list(known)
    for key in given:
        if key not in known:
            raise InputError(
                f'{where}: unknown key {key!r}{closest(str(key), known)}; known: '
                + (', '.join(known) or 'none')
            )


def mapping(given: Any, where: str) -> dict[str, Any]:
    """`given` as a map of names, an absent one empty; InputError for anything else."""
    if given is None:
        return {}
    if not isinstance(given, dict) or not all(isinstance(key, str) for key in given):
        raise InputError(f'{where} must map names to values, as in "name: value"')
    return given
