"""What was measured, as the fit wants it: steady points of one degree of freedom."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import InputError
from qzs_rig.estimation.estimate import DIRECTIONS, Curve, Estimate
from qzs_rig.estimation.events import RINGING, find_jumps
from qzs_rig.parameters import RunSpec
from qzs_rig.samples import Array
from qzs_rig.units import DOFS

NEEDED = ('dof', 'frequency_hz', 'transmissibility')
OPTIONAL = ('direction', 'phase_deg', 'std')
CSV_HELP = (
    'CSV with a header: dof (vertical, horizontal, …), direction (forward, reverse or none), '
    'frequency_hz, transmissibility |top|/|base|, and where known phase_deg (top against base) '
    'and std (standard deviation of the transmissibility)'
)
Row = tuple[str, str, float, float, float, float]
SETTLED = 'stepped_sine'
"""The estimator whose points have settled; any other followed a sine on the move."""
WINDOW = 4.0
"""Periods of an analysis window, and of its distance to the next, where the estimate says none."""
Complex = NDArray[np.complex128]
LEAST = 4
"""Points a degree of freedom needs; fewer do not even show a curve."""


@dataclass(frozen=True)
class Points:
    """Measured transmissibility of `dof`; all arrays (n,), in the order of measurement.

    `phase` is top against base in rad, NaN where it was not measured; `std` the standard
    deviation of the magnitude, NaN where nobody gave one; `chirp` the rate of the sweep in Hz/s,
    signed, 0 for a settled point. `direction` is forward, reverse or none.
    """

    dof: str
    direction: NDArray[np.str_]
    frequency_hz: Array
    magnitude: Array
    phase: Array
    std: Array
    chirp: Array

    def __len__(self) -> int:
        return len(self.frequency_hz)

    def take(self, which: NDArray[np.bool_]) -> Points:
        """The points `which` (n,) says."""
        arrays = [getattr(self, item.name)[which] for item in fields(self)[1:]]
        return Points(self.dof, *arrays)

    @property
    def phased(self) -> NDArray[np.bool_]:
        """Which points have a phase."""
        return np.isfinite(self.phase)

    @property
    def weighted(self) -> bool:
        """Whether every point has a standard deviation."""
        return bool(np.isfinite(self.std).all())


def joined(parts: Sequence[Points]) -> Points:
    """The curves of one degree of freedom one after the other."""
    arrays = [
        np.concatenate([getattr(part, item.name) for part in parts]) for item in fields(Points)[1:]
    ]
    return Points(parts[0].dof, *arrays)


def by_dof(parts: Sequence[Points], dof: str | None) -> tuple[Points, ...]:
    """One Points a degree of freedom in the rig's order, or of `dof` alone.

    Raises InputError where there is nothing to fit.
    """
    there = [name for name in DOFS if any(part.dof == name for part in parts)]
    if dof is not None and dof not in there:
        raise InputError(
            f'there are no measured points of {dof!r}; measured: {", ".join(there) or "nothing"}'
        )
    chosen = [joined([p for p in parts if p.dof == name]) for name in there if dof in (None, name)]
    if not chosen:
        raise InputError('there are no measured points; is the base excited above its floor?')
    for points in chosen:
        _refuse_poor(points)
    return tuple(chosen)


def _refuse_poor(points: Points) -> None:
    if len(points) < LEAST:
        raise InputError(
            f'{points.dof} has {len(points)} usable points; a fit needs {LEAST} or more'
        )
    if np.ptp(points.frequency_hz) < 0.01 * points.frequency_hz.max():
        raise InputError(
            f'{points.dof} was measured at one frequency, {points.frequency_hz[0]:g} Hz; '
            'a fit needs a curve: sweep or step the frequency'
        )
    if np.ptp(np.log(points.magnitude)) < 1e-6:
        raise InputError(
            f'{points.dof} has the same transmissibility {points.magnitude[0]:g} at every '
            'frequency; that tells nothing of springs or damping'
        )


def measured(estimate: Estimate, spec: RunSpec) -> list[Points]:
    """The usable points of every curve.

    Of a sweep the transition at a jump and the free vibration after it are left out, and of the
    rest only windows are kept that share no sample: the others would repeat their noise. The
    uncertainty of an estimate counts smoothing within a window, which is no noise: left out.
    """
    settings = estimate.quality.get('settings', {})
    apart = math.ceil(settings.get('periods', WINDOW) / settings.get('hop_periods', WINDOW))
    return [_of_curve(curve, spec, apart) for curve in estimate.curves]


def _of_curve(curve: Curve, spec: RunSpec, apart: int) -> Points:
    keep = np.isfinite(curve.magnitude) & (curve.magnitude > 0)
    settled = curve.estimator == SETTLED
    if not settled and len(keep) >= 3:
        for jump in find_jumps(curve):
            keep[jump.first : jump.last + RINGING] = False
    which = np.flatnonzero(keep)
    if not settled:
        which = which[:: max(apart, 1)]
    n = len(which)
    frequency_hz = curve.frequency_hz[which]
    return Points(
        curve.dof,
        np.full(n, curve.direction),
        frequency_hz,
        curve.magnitude[which],
        np.radians(curve.phase_deg[which]),
        np.full(n, np.nan),
        np.zeros(n) if settled else sweep_rate(spec, frequency_hz, curve.direction),
    )


def sweep_rate(spec: RunSpec, frequency_hz: Array, direction: str) -> Array:
    """Rate of the sweep at `frequency_hz` (n,) in Hz/s, signed; 0 where the run did not sweep.

    The eases at the ends of the band are left out of account: they are slower.
    """
    if spec.text('excitation.kind') != 'sweep' or direction == 'none':
        return np.zeros(len(frequency_hz))
    low, high = spec.number('excitation.frequency_low'), spec.number('excitation.frequency_high')
    ways = 2 if spec.text('excitation.direction') == 'there_and_back' else 1
    each = spec.number('excitation.duration') / ways
    sign = 1.0 if direction == 'forward' else -1.0
    if spec.text('excitation.spacing') == 'log':
        return sign * math.log(high / low) / each * frequency_hz
    return np.full(len(frequency_hz), sign * (high - low) / each)


def read_csv(path: Path) -> list[Points]:
    """The points of `path`, rows of one degree of freedom in the order of the file.

    `direction`, `phase_deg` and `std` may be left out or empty; the points count as settled.
    Raises InputError naming line, value and way out.
    """
    try:
        with path.open(newline='', encoding='utf-8-sig') as file:
            rows = list(_rows(path, csv.DictReader(file)))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f'{path} cannot be read as CSV: {error}; give a {CSV_HELP}') from error
    if not rows:
        raise InputError(f'{path} holds no rows below its header; give a {CSV_HELP}')
    dofs = dict.fromkeys(row[0] for row in rows)
    return [_from_rows(dof, [row for row in rows if row[0] == dof]) for dof in dofs]


def _rows(path: Path, reader: csv.DictReader[str]) -> Iterator[Row]:
    header = [name.strip() for name in reader.fieldnames or ()]
    missing = [name for name in NEEDED if name not in header]
    unknown = [name for name in header if name not in NEEDED + OPTIONAL]
    if missing or unknown or len(set(header)) < len(header):
        what = f'lacks {", ".join(missing)}' if missing else f'has {", ".join(unknown) or header}'
        raise InputError(f'{path}: the header {what}; give a {CSV_HELP}')
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


def _from_rows(dof: str, rows: list[Row]) -> Points:
    direction = np.array([row[1] for row in rows])
    frequency_hz, magnitude, phase, std = np.array([row[2:] for row in rows]).T
    return Points(dof, direction, frequency_hz, magnitude, phase, std, np.zeros(len(rows)))
