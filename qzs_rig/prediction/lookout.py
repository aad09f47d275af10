"""The predictive abort: the plan of a run followed along the theory, before the plate does it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from qzs_rig.errors import InputError, LimitError
from qzs_rig.excitation.drive import Drive
from qzs_rig.parameters import RunSpec
from qzs_rig.prediction.curve import Prediction
from qzs_rig.samples import NS, Array
from qzs_rig.units import DOFS, displacement_unit

GRID_S = 0.02
"""Step of time in which the plan is followed."""


class Foreseen(NamedTuple):
    """The run must ramp down from `sample` on, and `reason` says why."""

    sample: int
    reason: str


class Path(NamedTuple):
    """Stroke (n,) and number of the branch (n,) along a plan; NaN and -1 where theory is silent."""

    stroke: Array
    branch: NDArray[np.intp]


def refuse_vague(spec: RunSpec) -> None:
    """Raises InputError for a predictive abort that has no limit, or no time to ramp down."""
    if not spec.flag('run.predictive_abort'):
        return
    if not _limits(spec):
        driven = [dof for dof in DOFS if spec.number(f'excitation.amplitude.{dof}')]
        raise InputError(
            'run.predictive_abort has nothing to hold; set '
            + ' or '.join(f'run.stroke_limit.{dof}' for dof in driven or DOFS)
        )
    lead, ramp = spec.number('run.lead_time'), spec.number('excitation.ramp')
    if lead < ramp:
        raise InputError(
            f'run.lead_time = {lead:g} s is shorter than the ramp down, excitation.ramp = '
            f'{ramp:g} s: the stroke would come before the base is at rest; raise run.lead_time'
        )


def look_out(spec: RunSpec, drive: Drive, predictions: Sequence[Prediction]) -> Foreseen | None:
    """Where `drive` must be stopped lest a relative stroke exceeds its limit; None if nowhere.

    It depends on the RunSpec alone, so every form of a run stops at the same sample. Where theory
    knows no stable motion, no limit can be held: that stops the run, too. Raises LimitError where
    the ramp up itself would end beyond the limit, InputError where a prediction is missing.
    """
    refuse_vague(spec)
    if not spec.flag('run.predictive_abort'):
        return None
    t = np.arange(0.0, drive.duration, GRID_S)
    limits, frequency_hz = _limits(spec), drive.frequencies_hz(t)
    missing = set(limits) - {prediction.dof for prediction in predictions}
    if missing:
        raise InputError(
            f'there is no theory of {", ".join(sorted(missing))}, so its stroke cannot be '
            'foreseen; leave run.predictive_abort false'
        )
    beyond = [
        _first_beyond(prediction, limits[prediction.dof], frequency_hz)
        for prediction in predictions
        if prediction.dof in limits
    ]
    found = [one for one in beyond if one]
    if not found:
        return None
    place, what = min(found)
    lead = spec.number('run.lead_time')
    early = float(t[place]) - lead
    if early <= 0.0:
        raise LimitError(f'{what}, right after the start; lower excitation.amplitude, or start '
                         'where the plate moves less')  # fmt: skip
    return Foreseen(math.floor(early * NS / drive.step_ns), f'{what}, {lead:g} s ahead')


def follow(prediction: Prediction, frequency_hz: Array) -> Path:
    """The steady states along frequencies (n,): on the branch of least stroke first, on from
    there, and at the end of a branch to the stable one nearest in stroke."""
    table = np.array([b.at(frequency_hz, b.stroke) for b in prediction.branches])
    stroke = np.full(len(frequency_hz), np.nan)
    number = np.full(len(frequency_hz), -1, dtype=np.intp)
    for branch, first, last in _stays(table):
        stroke[first:last], number[first:last] = table[branch, first:last], branch
    return Path(stroke, number)


def _stays(table: Array) -> Iterator[tuple[int, int, int]]:
    """Branch, first and one-past-last place of each stretch, from strokes (branches, n)."""
    known = np.isfinite(table)
    somewhere = np.flatnonzero(known.any(axis=0))
    before, at = 0.0, 0
    while (later := somewhere[somewhere >= at]).size:
        at = int(later[0])
        gaps = np.where(known[:, at], np.abs(table[:, at] - before), np.inf)
        branch = int(np.argmin(gaps))
        ends = np.flatnonzero(~known[branch, at:])
        last = at + int(ends[0]) if ends.size else table.shape[1]
        yield branch, at, last
        before, at = float(table[branch, last - 1]), last


def _first_beyond(
    prediction: Prediction, limit: float, frequency_hz: Array
) -> tuple[int, str] | None:
    path = follow(prediction, frequency_hz)
    beyond = np.flatnonzero(~(path.stroke <= limit))
    if not beyond.size:
        return None
    at = int(beyond[0])
    if np.isnan(path.stroke[at]):
        return at, (
            f'theory knows no stable {prediction.dof.replace("_", " ")} motion at '
            f'{frequency_hz[at]:.4g} Hz, where run.stroke_limit.{prediction.dof} = {limit:g} '
            'cannot be held'
        )
    names = [branch.name for branch in prediction.branches]
    here, before = (int(path.branch[k]) for k in (at, max(at - 1, 0)))
    jumps = f' after a jump from the {names[before]} branch' if 0 <= before != here else ''
    unit = displacement_unit(prediction.dof)
    dof = prediction.dof
    text = (
        f'theory foresees a {dof.replace("_", " ")} stroke of {path.stroke[at]:.4g} {unit} on the '
        f'{names[here]} branch at {frequency_hz[at]:.4g} Hz{jumps}, beyond '
        f'run.stroke_limit.{dof} = {limit:g} {unit}'
    )
    return at, text


def _limits(spec: RunSpec) -> dict[str, float]:
    """The limit of each driven degree of freedom that has one."""
    given = {dof: spec.optional(f'run.stroke_limit.{dof}') for dof in DOFS}
    return {
        dof: limit
        for dof, limit in given.items()
        if limit is not None and spec.number(f'excitation.amplitude.{dof}')
    }
