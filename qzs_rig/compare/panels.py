"""What the figure of one degree of freedom shows, whoever draws it: curves, lines, ranges."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from qzs_rig.estimation.estimate import Curve, Estimate, Event
from qzs_rig.prediction.curve import Prediction
from qzs_rig.report.names import direction_order, dof_order
from qzs_rig.samples import Array

Labelled = Sequence[tuple[str, Estimate]]
"""Runs with the names they are shown by, the first one first."""


@dataclass(frozen=True)
class Shown:
    """A measured curve with its events, and the run it is from: number and label."""

    item: int
    label: str
    curve: Curve
    events: tuple[Event, ...]


@dataclass(frozen=True)
class Line:
    """A line to draw, (n,) each, with NaN where it breaks."""

    frequency_hz: Array
    magnitude: Array
    phase_deg: Array


@dataclass(frozen=True)
class Ranges:
    """First view of the axes; `thd_percent` is None where no curve has a distortion to show."""

    frequency_hz: tuple[float, float]
    log_frequency: bool
    magnitude: tuple[float, float]
    phase_deg: tuple[float, float]
    thd_percent: float | None


def dofs_of(estimates: Labelled, theory: Sequence[Prediction]) -> list[str]:
    """Every degree of freedom with something to draw, in the rig's order."""
    names = {curve.dof for _, estimate in estimates for curve in estimate.curves}
    return sorted(names | {curve.dof for curve in theory}, key=dof_order)


def shown(dof: str, estimates: Labelled) -> list[Shown]:
    """The measured curves of `dof`; the events of a direction go with its first curve."""
    result: list[Shown] = []
    for item, (label, estimate) in enumerate(estimates):
        curves = [curve for curve in estimate.curves if curve.dof == dof]
        claimed: set[str] = set()
        for curve in sorted(curves, key=lambda curve: direction_order(curve.direction)):
            events = [e for e in estimate.events if (e.dof, e.direction) == (dof, curve.direction)]
            free = tuple(events) if curve.direction not in claimed else ()
            claimed.add(curve.direction)
            result.append(Shown(item, label, curve, free))
    return result


def ranges(curves: Sequence[Curve], theory: Sequence[Prediction]) -> Ranges:
    """First view: all that was measured and T = 1; theory counts only where nothing was."""
    f = _finite([curve.frequency_hz for curve in curves]) if curves else np.empty(0)
    branches = [branch for prediction in theory for branch in prediction.branches]
    f = f if f.size else _finite([branch.frequency_hz for branch in branches])
    T = _finite([curve.magnitude for curve in curves])
    T = T if T.size else _finite([branch.transmissibility[branch.stable] for branch in branches])
    T = T[(T > 1e-4) & (T < 1e4)]
    phase = _finite([item.phase_deg for item in (curves or branches)])
    thd = _finite([curve.thd for curve in curves])
    low, high = (float(f.min()), float(f.max())) if f.size else (1.0, 10.0)
    wraps = bool(np.any(phase > 45))
    return Ranges(
        (low, high) if high > low else (0.9 * low, 1.1 * high),
        high >= 5 * low > 0,
        (min(float(T.min(initial=1.0)) / 1.5, 0.6), max(float(T.max(initial=1.0)) * 1.8, 1.8)),
        (-190.0, 190.0 if wraps else 15.0),
        max(120 * float(thd.max()), 1.0) if thd.size else None,
    )


def phase_line(curve: Curve) -> Line:
    """The curve as a line that breaks where its phase leaps through ±180 degrees."""
    leaps = np.flatnonzero(np.abs(np.diff(curve.phase_deg)) > 180) + 1
    columns = (curve.frequency_hz, curve.magnitude, curve.phase_deg)
    return Line(*(np.insert(column, leaps, np.nan) for column in columns))


def theory_line(theory: Prediction, stable: bool) -> Line:
    """All stable or all unstable stretches of `theory`, with breaks between; an unstable stretch
    reaches its stable neighbours, so that nothing is left blank."""
    pieces: list[tuple[Array, Array, Array]] = []
    gap = np.array([np.nan])
    for branch in theory.branches:
        drawn = (branch.stable[:-1] & branch.stable[1:]) == stable
        for first, last in _runs(drawn):
            cut = slice(first, last + 1)
            phase = branch.phase_deg[cut]
            # a phase that leaps through ±180 degrees is no line
            phase = np.where(np.abs(np.diff(phase, prepend=phase[0])) > 180, np.nan, phase)
            pieces.append((branch.frequency_hz[cut], branch.transmissibility[cut], phase))
            pieces.append((gap, gap, gap))
    if not pieces:
        return Line(np.empty(0), np.empty(0), np.empty(0))
    return Line(*(np.concatenate(column) for column in zip(*pieces, strict=True)))


def arrow_indices(curve: Curve, count: int = 6) -> list[int]:
    """Points of `curve` to set an arrow on, about evenly along the logarithm of frequency."""
    usable = np.flatnonzero(np.isfinite(curve.magnitude) & (curve.frequency_hz > 0))
    if usable.size < 2:
        return []
    x = np.log(curve.frequency_hz[usable])
    # Forward at odd places, reverse at even ones: where the curves agree both can be seen.
    places = np.linspace(x.min(), x.max(), 2 * count + 2)[1:-1]
    wanted = places[1::2] if curve.direction == 'reverse' else places[::2]
    return sorted({int(usable[np.argmin(np.abs(x - place))]) for place in wanted})


def _runs(flags: NDArray[np.bool_]) -> Iterable[tuple[int, int]]:
    """First and one-past-last index of every run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]])))
    return [(int(a), int(b)) for a, b in list(pairwise(edges))[::2]]


def _finite(arrays: Sequence[Array]) -> Array:
    values = np.concatenate([np.ravel(array) for array in arrays]) if arrays else np.empty(0)
    return np.asarray(values[np.isfinite(values)])
