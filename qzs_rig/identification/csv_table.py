"""Measured curves from a CSV file."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from qzs_rig.errors import InputError
from qzs_rig.estimation.estimate import DIRECTIONS
from qzs_rig.identification.points import Points
from qzs_rig.units import DOFS

NEEDED = ('dof', 'frequency_hz', 'transmissibility')
OPTIONAL = ('direction', 'phase_deg', 'std')
HELP = (
    'CSV with a header: dof (vertical, horizontal, …), direction (forward, reverse or none), '
    'frequency_hz, transmissibility |top|/|base|, and where known phase_deg (top against base) '
    'and std (standard deviation of the transmissibility)'
)


def read(path: Path) -> list[Points]:
    """The points of `path`, rows of one degree of freedom in the order of the file.

    `direction`, `phase_deg` and `std` may be left out or empty; the points count as settled.
    Raises InputError naming line, value and way out.
    """
    try:
        with path.open(newline='', encoding='utf-8-sig') as file:
            rows = list(_rows(path, csv.DictReader(file)))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f'{path} cannot be read as CSV: {error}; give a {HELP}') from error
    if not rows:
        raise InputError(f'{path} holds no rows below its header; give a {HELP}')
    dofs = dict.fromkeys(row[0] for row in rows)
    return [_points(dof, [row for row in rows if row[0] == dof]) for dof in dofs]


Row = tuple[str, str, float, float, float, float]


def _rows(path: Path, reader: csv.DictReader[str]) -> Iterator[Row]:
    header = [name.strip() for name in reader.fieldnames or ()]
    missing = [name for name in NEEDED if name not in header]
    unknown = [name for name in header if name not in NEEDED + OPTIONAL]
    if missing or unknown or len(set(header)) < len(header):
        what = f'lacks {", ".join(missing)}' if missing else f'has {", ".join(unknown) or header}'
        raise InputError(f'{path}: the header {what}; give a {HELP}')
    reader.fieldnames = header
    for row in reader:
        where = f'{path}, line {reader.line_num}'
        yield (
            _word(where, row, 'dof', DOFS),
            _word(where, row, 'direction', DIRECTIONS, 'none'),
            _positive(where, row, 'frequency_hz'),
            _positive(where, row, 'transmissibility'),
            math.radians(_number(where, row, 'phase_deg')),
            _positive(where, row, 'std') if (row.get('std') or '').strip() else math.nan,
        )


def _word(
    where: str, row: dict[str, str], name: str, known: tuple[str, ...], default: str = ''
) -> str:
    word = (row.get(name) or '').strip() or default
    if word not in known:
        raise InputError(f'{where}: {name} is {word!r}; give one of {", ".join(known)}')
    return word


def _number(where: str, row: dict[str, str], name: str) -> float:
    text = (row.get(name) or '').strip()
    if not text and name in OPTIONAL:
        return math.nan
    try:
        return float(text)
    except ValueError:
        raise InputError(f'{where}: {name} is {text!r}, not a number') from None


def _positive(where: str, row: dict[str, str], name: str) -> float:
    value = _number(where, row, name)
    if not (value > 0 and math.isfinite(value)):
        raise InputError(f'{where}: {name} is {value:g}; give a number above 0')
    return value


def _points(dof: str, rows: list[Row]) -> Points:
    direction = np.array([row[1] for row in rows])
    frequency_hz, magnitude, phase, std = np.array([row[2:] for row in rows]).T
    return Points(dof, direction, frequency_hz, magnitude, phase, std, np.zeros(len(rows)))
