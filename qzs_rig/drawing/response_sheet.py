"""A frequency response as figures and curves: what is drawn, not how."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from qzs_rig.drawing.sheet import Line, Panel, Sheet
from qzs_rig.report.names import dof_name
from qzs_rig.samples import Array
from qzs_rig.theory.balance.response import Branch, Event, FrequencyResponse
from qzs_rig.units import TRANSLATIONS

HUES = 4
EVENT_NAMES = {
    'fold': 'fold',
    'period_doubling': 'period doubling',
    'symmetry_breaking': 'symmetry breaking',
    'neimark_sacker': 'Neimark-Sacker',
}


def sheet(response: FrequencyResponse) -> Sheet:
    """Transmissibility, amplitude and phase over frequency; unstable motions dashed."""
    own = response.oscillator
    unit = 'w / L20' if own.dof in TRANSLATIONS else 'w, rad'
    return Sheet(
        'response',
        f'{dof_name(own.dof)}, law {own.law.name}: zeta = {own.zeta:.4g}, '
        f'amplitude = {own.amplitude:.4g}',
        'Fundamentals. Frequency over omega0. Unstable motions are dashed.',
        (
            Panel('(a) transmissibility', 'Ω', '|u / v|', _lines(response, 'T'), 'xy'),
            Panel('(b) relative motion', 'Ω', unit, _lines(response, 'amplitude'), 'xy'),
            Panel('(c) phase of u against v', 'Ω', 'degrees', _lines(response, 'phase_deg'), 'x'),
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


def _lines(response: FrequencyResponse, what: str) -> tuple[Line, ...]:
    lines = []
    for number, branch in enumerate(response.branches):
        y = _whole(branch, what)
        style, name = number % HUES, f'branch {number + 1}'
        for stable, stroke in ((True, 'solid'), (False, 'dashed')):
            own = shown(branch, stable)
            if own.any():
                label = name if stable else f'{name}, unstable'
                lines.append(Line(label, branch.omega, np.where(own, y, np.nan), style, stroke))
    for kind, name in EVENT_NAMES.items():
        events = [event for event in response.events if event.kind == kind]
        if events:
            omega = np.array([event.omega for event in events])
            style = list(EVENT_NAMES).index(kind)
            lines.append(Line(name, omega, _values(events, what), style, 'marks'))
    return tuple(lines)


def _whole(branch: Branch, what: str) -> Array:
    y = np.array(getattr(branch, what))
    if what == 'phase_deg':
        # a jump from -180 to 180 is no motion
        y[1:][np.abs(np.diff(y)) > 180.0] = np.nan
    return y


def shown(branch: Branch, stable: bool) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Points of one stability, and the neighbours that the line needs to reach the others."""
    own = branch.stable == stable
    if not stable:
        own = own | np.append(own[1:], False) | np.append(False, own[:-1])
    return np.asarray(own)


def _values(events: list[Event], what: str) -> Array:
    return np.array([getattr(event, what) for event in events])
