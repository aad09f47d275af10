"""One dimension of a campaign: listed values, or a range between two ends."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import InputError
from qzs_rig.parameters import Parameter, RunSpec, Value
from qzs_rig.samples import Array

Column = NDArray[Any]
"""One value a point: numbers, words or yes/no."""

MOST = 10_000_000
"""Values of one range, and samples of a hypercube: both are kept in memory."""
SCALE = Parameter(
    'scale', str, 'linear', '', 'even steps or equal ratios', choices=('linear', 'log')
)
COUNT = Parameter('count', int, None, '', 'values in a grid', 1, MOST)


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
        """'0.1, 0.2, 0.5': the values as given."""
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
        """'0.1 … 0.5 (log)': ends and scale."""
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
    if parameter.kind is not float:
        raise InputError(f'{name}: a range is for real numbers; list the values')
    ends = [replace(parameter, name=end, default=None, replaces=()) for end in ('from', 'to')]
    declared = (*ends, SCALE, *((COUNT,) if grid else ()))
    spec = checked(name, declared, given)
    missing = [item.name for item in declared if item.name not in spec]
    if missing:
        raise InputError(f'{name}: {", ".join(missing)} is missing')
    low, high, scale = spec.number('from'), spec.number('to'), spec.text('scale')
    if scale == 'log' and not low * high > 0.0:
        raise InputError(f'{name}: a log scale from {low:g} to {high:g} is none; use linear')
    return Range(parameter, low, high, scale, spec.count('count') if grid else None)


def checked(where: str, declared: Iterable[Parameter], given: Mapping[str, Any]) -> RunSpec:
    """The values `given` for `declared` parameters of a part of a plan; InputError says which."""
    try:
        return RunSpec.of(declared, given)
    except InputError as error:
        raise InputError(f'{where}: {error}') from error
