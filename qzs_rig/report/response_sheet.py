"""A frequency response as a sheet and as rows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from qzs_rig.report.lines import STROKES, broken, stretches
from qzs_rig.report.names import dof_name
from qzs_rig.report.sheet import INK, Curve, Item, Panel, Points, Sheet, hue
from qzs_rig.theory.balance.response import Branch, FrequencyResponse
from qzs_rig.theory.balance.variation import VariedBranch
from qzs_rig.units import TRANSLATIONS

EVENT_MARKS = {
    'fold': 'dot',
    'period_doubling': 'square',
    'symmetry_breaking': 'diamond',
    'neimark_sacker': 'up',
}


def response_sheet(response: FrequencyResponse) -> Sheet:
    """Transmissibility, amplitude and phase over frequency; unstable motions dashed."""
    own = response.oscillator
    unit = 'w / L20' if own.dof in TRANSLATIONS else 'w, rad'
    return Sheet(
        'response',
        f'{dof_name(own.dof)}, law {own.law.name}: zeta = {own.zeta:.4g}, '
        f'amplitude = {own.amplitude:.4g}',
        'Fundamentals. Frequency over omega0. Unstable motions are dashed.',
        (
            Panel('(a) transmissibility', 'Ω', '|u / v|', _items(response, 'T'), 'xy', 1.0),
            Panel('(b) relative motion', 'Ω', unit, _items(response, 'amplitude'), 'xy'),
            Panel('(c) phase of u against v', 'Ω', 'degrees', _items(response, 'phase_deg'), 'x'),
        ),
        columns=3,
    )


def rows(response: FrequencyResponse) -> Iterator[str]:
    """`response.csv`: one motion a line."""
    yield 'branch,omega,T,amplitude,phase_deg,stable,harmonics'
    for number, b in enumerate(response.branches):
        columns = (b.omega, b.T, b.amplitude, b.phase_deg)
        for k, values in enumerate(zip(*(c.tolist() for c in columns), strict=True)):
            numbers = ','.join(repr(value) for value in values)
            yield f'{number},{numbers},{int(b.stable[k])},{b.harmonics[k]}'


def branch_curves(
    branches: Iterable[Branch | VariedBranch],
    what: str,
    label: str,
    colour: str,
    scale: float = 1.0,
    width: float = 1.8,
    over: str = 'omega',
) -> Iterator[Curve]:
    """`what` (T, amplitude, phase_deg) of `branches` `over` omega or value times `scale`, unstable
    motions dashed, under one label."""
    for branch in branches:
        for stable, own in stretches(branch.stable):
            x, y = scale * getattr(branch, over), np.where(own, getattr(branch, what), np.nan)
            if what == 'phase_deg':
                x, y = broken(x, y)
            yield Curve(label, x, y, colour, STROKES[stable], width)


def _items(response: FrequencyResponse, what: str) -> tuple[Item, ...]:
    """A colour a branch, a mark a kind of event."""
    items: list[Item] = []
    for number, branch in enumerate(response.branches):
        items += branch_curves([branch], what, f'branch {number + 1}', hue(number))
    for kind, mark in EVENT_MARKS.items():
        events = [event for event in response.events if event.kind == kind]
        if events:
            omega = np.array([event.omega for event in events])
            y = np.array([getattr(event, what) for event in events])
            items.append(Points(kind.replace('_', ' '), omega, y, INK, mark))
    return tuple(items)
