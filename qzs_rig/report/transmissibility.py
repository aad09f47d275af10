"""Measured transmissibility over its theory: magnitude, phase and distortion over frequency."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from qzs_rig.estimation.estimate import EVENT_KINDS, Curve, Estimate, Event
from qzs_rig.prediction.curve import Fold, Prediction
from qzs_rig.prediction.labels import NEAR, NONE, label
from qzs_rig.report import sheet
from qzs_rig.report.names import (
    direction_name,
    direction_order,
    dof_name,
    dof_order,
    event_name,
)
from qzs_rig.report.sheet import (
    STROKE_OF,
    Band,
    Item,
    Panel,
    Points,
    Sheet,
    broken,
    joined,
    stretches,
)
from qzs_rig.report.table import number
from qzs_rig.samples import Array

Labelled = Sequence[tuple[str, Estimate]]
"""Runs with the names they are shown by, the first one first."""

HUES = {
    'forward': ('#0b62a4', '#56a9dd', '#1b9e8a', '#7b6cc4'),
    'reverse': ('#c2410c', '#f0984f', '#b83280', '#94720b'),
    'none': ('#3f4d58', '#8795a1', '#2f7d4f', '#a0688f'),
}
THEORY_HUES = ('#22303c', '#7a5195', '#2f7d4f', '#94720b')
ARROWS = {'forward': 'right', 'reverse': 'left'}
EVENT_MARKS = {'onset': 'diamond', 'peak': 'dot', 'jump_up': 'up', 'jump_down': 'down'}
FOLD_MARKS = {'jump_up': 'arrow_up', 'jump_down': 'arrow_down'}
FREQUENCY, MAGNITUDE, PHASE = 'frequency, Hz', '|T|, top / base', 'phase, °'
DOTTED = 150
"""Up to so many points are marked; more melt into a line."""


@dataclass(frozen=True)
class Shown:
    """A measured curve with its events, and the run it is from: number and name; `several` where
    the run must be told."""

    item: int
    run: str
    curve: Curve
    events: tuple[Event, ...]
    several: bool

    @property
    def label(self) -> str:
        """The name in the key."""
        words = direction_name(self.curve.direction)
        return f'{self.run}, {words}' if self.several else words

    @property
    def colour(self) -> str:
        """A family a direction, a shade a run."""
        return hue(self.item, self.curve.direction)


def hue(item: int, direction: str) -> str:
    """Colour of run number `item` (0 first) in `direction`."""
    family = HUES.get(direction, HUES['none'])
    return family[item % len(family)]


def dofs_of(estimates: Labelled, theory: Sequence[Prediction]) -> list[str]:
    """Every degree of freedom with something to draw, in the rig's order."""
    names = {curve.dof for _, estimate in estimates for curve in estimate.curves}
    return sorted(names | {curve.dof for curve in theory}, key=dof_order)


def dof_sheet(
    dof: str, estimates: Labelled, theory: Sequence[Prediction], name: str = 'transmissibility'
) -> Sheet:
    """Magnitude over phase over, where there is any, distortion of `dof`."""
    curves = shown(dof, estimates)
    predictions = [curve for curve in theory if curve.dof == dof]
    magnitude: list[Item] = []
    phase: list[Item] = []
    for item in curves:
        magnitude += _measured(item, predictions)
        f, deg = broken(item.curve.frequency_hz, item.curve.phase_deg)
        phase.append(_line(item, f, deg))
    # thin and on top: a good measurement would hide it
    for k, prediction in enumerate(predictions):
        colour = THEORY_HUES[k % len(THEORY_HUES)]
        magnitude += _branches(prediction, 'transmissibility', colour)
        phase += _branches(prediction, 'phase_deg', colour)
        magnitude += _folds(prediction, colour)
    panels = _panels([item.curve for item in curves], predictions, magnitude, phase)
    return Sheet(
        name,
        dof_name(dof)[:1].upper() + dof_name(dof)[1:],
        '',
        (*panels, *_distortion(curves, panels[1])),
        linked=True,
        lines=tuple(_sentence(item) for item in curves),
        marks=_marks(curves),
    )


def _distortion(curves: Sequence[Shown], above: Panel) -> list[Panel]:
    """The panel of THD below `above`; none where no curve has any."""
    lines = tuple(_line(item, item.curve.frequency_hz, 100 * item.curve.thd) for item in curves)
    finite = _finite([line.y for line in lines])
    if not finite.size:
        return []
    span = (0.0, max(1.2 * float(finite.max()), 1.0))
    look: dict[str, Any] = {'y_label': 'THD, %', 'y_range': span, 'y_step': None, 'height': 0.27}
    return [replace(above, items=lines, **look)]


def _marks(curves: Sequence[Shown]) -> tuple[tuple[str, str], ...]:
    """What the arrows and the marks of events stand for."""
    kinds = dict.fromkeys(event.kind for item in curves for event in item.events)
    ways = dict.fromkeys(item.curve.direction for item in curves)
    return (
        *((ARROWS[way], way) for way in ways if way in ARROWS),
        *((EVENT_MARKS.get(kind, 'square'), event_name(kind)) for kind in kinds),
    )


def overview(
    name: str, title: str, dofs: Sequence[str], estimates: Labelled, theory: Sequence[Prediction]
) -> Sheet:
    """Magnitude over phase, a column each of `dofs`: for a README or a paper."""
    sheets = [dof_sheet(dof, estimates, theory) for dof in dofs]
    above = (
        replace(one.panels[0], title=dof_name(dof)) for one, dof in zip(sheets, dofs, strict=True)
    )
    panels = (*above, *(one.panels[1] for one in sheets))
    return Sheet(name, title, '', panels, columns=len(dofs), linked=True)


def shown(dof: str, estimates: Labelled) -> list[Shown]:
    """The measured curves of `dof`; the events of a direction go with its first curve."""
    result: list[Shown] = []
    for item, (run, estimate) in enumerate(estimates):
        curves = [curve for curve in estimate.curves if curve.dof == dof]
        claimed: set[str] = set()
        for curve in sorted(curves, key=lambda curve: direction_order(curve.direction)):
            events = [e for e in estimate.events if (e.dof, e.direction) == (dof, curve.direction)]
            free = tuple(events) if curve.direction not in claimed else ()
            claimed.add(curve.direction)
            result.append(Shown(item, run, curve, free, len(estimates) > 1))
    return result


def _measured(item: Shown, predictions: Sequence[Prediction]) -> Iterator[Item]:
    """The curve with its interval, arrows the way the sweep went, and events."""
    curve, colour = item.curve, item.colour
    f, T = curve.frequency_hz, curve.magnitude
    yield replace(_line(item, f, T), notes=_point_notes(curve, predictions))
    wide = NEAR * curve.uncertainty
    if np.isfinite(wide).any():
        # a logarithmic axis knows no 0
        yield Band(item.label, f, np.maximum(T - wide, 1e-3 * T), T + wide, colour)
    if len(f) <= DOTTED:
        yield Points(item.label, f, T, colour, size=3.4)
    if curve.direction in ARROWS and (at := arrow_indices(curve)):
        yield Points(item.label, f[at], T[at], colour, ARROWS[curve.direction], 6.0)
    for kind in dict.fromkeys(event.kind for event in item.events):
        events = [event for event in item.events if event.kind == kind]
        yield Points(
            item.label,
            np.array([event.frequency_hz for event in events]),
            np.array([event.magnitude for event in events]),
            colour,
            EVENT_MARKS.get(kind, 'square'),
            7.5,
            hollow=True,
            notes=[f'{event_name(kind)}, ± {event.resolution_hz:.3f} Hz' for event in events],
        )


def _line(item: Shown, x: Array, y: Array) -> sheet.Curve:
    # the forward line is broad, so that the reverse one shows on it where they agree
    width = 3.0 if item.curve.direction == 'forward' else 1.5
    return sheet.Curve(item.label, x, y, item.colour, width=width)


def _point_notes(curve: Curve, predictions: Sequence[Prediction]) -> list[str]:
    """Branch and distance of each point of `curve`; none without exactly one theory."""
    if len(predictions) != 1:
        return []
    found = label(curve, predictions[0])
    return [
        f'{name} branch' + (f', z = {z:+.2f}' if math.isfinite(z) else '')
        if name != NONE
        else 'on no branch'
        for name, z in zip(found.branch, found.z.tolist(), strict=True)
    ]


def _branches(theory: Prediction, what: str, colour: str) -> Iterator[Item]:
    """Stable branches solid, unstable ones dashed, each kind as one curve."""
    pieces: dict[bool, list[tuple[Array, Array]]] = {True: [], False: []}
    for branch in theory.branches:
        for stable, own in stretches(branch.stable):
            y = np.where(own, getattr(branch, what), np.nan)
            f = branch.frequency_hz
            pieces[stable].append(broken(f, y) if what == 'phase_deg' else (f, y))
    for stable, found in pieces.items():
        if found:
            name = theory.label if stable else f'{theory.label}, unstable'
            yield sheet.Curve(name, *joined(found), colour, STROKE_OF[stable], 0.9)


def _folds(theory: Prediction, colour: str) -> Iterator[Item]:
    """An arrow where a sweep cannot go on."""
    for kind in dict.fromkeys(fold.kind for fold in theory.folds):
        folds = [fold for fold in theory.folds if fold.kind == kind]
        yield Points(
            f'{theory.label}, folds',
            np.array([fold.frequency_hz for fold in folds]),
            np.array([fold.transmissibility[0] for fold in folds]),
            colour,
            FOLD_MARKS[kind],
            7.0,
            notes=[_fold_note(fold) for fold in folds],
        )


def _fold_note(fold: Fold) -> str:
    T, after = fold.transmissibility
    lands = f'to T = {after:.4g} on the {fold.lands} branch' if fold.lands else 'to where?'
    return f'{event_name(fold.kind)} at {fold.frequency_hz:.4f} Hz from T = {T:.4g} {lands}'


def arrow_indices(curve: Curve, count: int = 6) -> list[int]:
    """Points of `curve` to set an arrow on, about evenly along the logarithm of frequency."""
    usable = np.flatnonzero(np.isfinite(curve.magnitude) & (curve.frequency_hz > 0))
    if usable.size < 2:
        return []
    x = np.log(curve.frequency_hz[usable])
    # forward at odd places, reverse at even ones: where the curves agree both can be seen
    places = np.linspace(x.min(), x.max(), 2 * count + 2)[1:-1]
    wanted = places[1::2] if curve.direction == 'reverse' else places[::2]
    return sorted({int(usable[np.argmin(np.abs(x - place))]) for place in wanted})


def _panels(
    curves: Sequence[Curve],
    theory: Sequence[Prediction],
    magnitude: Sequence[Item],
    phase: Sequence[Item],
) -> tuple[Panel, ...]:
    """First view: all that was measured and T = 1; theory counts only where nothing was."""
    branches = [branch for prediction in theory for branch in prediction.branches]
    f = _finite([curve.frequency_hz for curve in curves])
    f = f if f.size else _finite([branch.frequency_hz for branch in branches])
    T = _finite([curve.magnitude for curve in curves])
    T = T if T.size else _finite([branch.transmissibility[branch.stable] for branch in branches])
    T = T[(T > 1e-4) & (T < 1e4)]
    wraps = bool(np.any(_finite([item.phase_deg for item in (curves or branches)]) > 45))
    low, high = (float(f.min()), float(f.max())) if f.size else (1.0, 10.0)
    log = 'x' if high >= 5 * low > 0 else ''
    margin = 0.02 * (high - low) or 0.1 * high
    view = (low / 1.03, high * 1.03) if log else (low - margin, high + margin)
    heights = (min(float(T.min(initial=1.0)) / 1.5, 0.6), max(float(T.max(initial=1.0)) * 1.8, 1.8))
    return (
        Panel(
            '', FREQUENCY, MAGNITUDE, tuple(magnitude), f'{log}y', 1.0, view, heights, None, 0.62
        ),
        Panel(
            '', FREQUENCY, PHASE, tuple(phase), log, None, view,
            (-190.0, 190.0 if wraps else 15.0), 90.0, 0.3,
        ),
    )  # fmt: skip


def _sentence(item: Shown) -> str:
    """The events of one curve as a sentence: 'isolation onset at 1.52 Hz, …'."""
    order = {kind: k for k, kind in enumerate(EVENT_KINDS)}
    events = sorted(item.events, key=lambda event: order.get(event.kind, len(order)))
    said = []
    for event in events:
        height = f' (T = {number(event.magnitude)})' if event.kind == 'peak' else ''
        said.append(f'{event_name(event.kind)} at {number(event.frequency_hz)} Hz{height}')
    who = item.label if item.several else item.label[:1].upper() + item.label[1:]
    return f'{who}: {", ".join(said) or "no onset, peak or jump found"}.'


def _finite(arrays: Sequence[Array]) -> Array:
    values = np.concatenate([np.ravel(array) for array in arrays]) if arrays else np.empty(0)
    return np.asarray(values[np.isfinite(values)])
