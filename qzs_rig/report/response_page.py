"""What is said of a frequency response: document, tables, sheets, cautions; and its files."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from qzs_rig.files import write_new
from qzs_rig.report.names import dof_name
from qzs_rig.report.page import Part, footer, header
from qzs_rig.report.sheet import (
    INK,
    STROKE_OF,
    Curve,
    Item,
    Panel,
    Points,
    Sheet,
    broken,
    hue,
    stretches,
)
from qzs_rig.report.table import Table
from qzs_rig.report.write import pictures, write_page
from qzs_rig.theory.balance.frequency_response import Branch, FrequencyResponse
from qzs_rig.theory.oscillator import Oscillator
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
    branches: Iterable[Branch],
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
            yield Curve(label, x, y, colour, STROKE_OF[stable], width)


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


ARTEFACT = 1e-2
"""Unbalanced force over the drive that a user is warned of."""


@dataclass(frozen=True)
class Answer:
    """`document` as printed with --json, `text` without; what --out writes."""

    title: str
    document: dict[str, Any]
    tables: list[Table]
    sheets: list[Sheet]
    csv: list[str]
    cautions: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """The tables."""
        return '\n\n'.join(table.to_text() for table in self.tables if table.rows)


def all_branches(found: FrequencyResponse, method: str = 'harmonic balance') -> Answer:
    """What was found, and by which `method`."""
    document = {
        **_who(found.oscillator, (found.low, found.high)),
        'method': method,
        'harmonics': found.harmonics,
        'branches': [_branch(branch) for branch in found.branches],
        'folds': [_event(event) for event in found.folds],
        'events': [_event(event) for event in found.events if event.kind != 'fold'],
        'onset_omega': list(found.onset_omega),
        'peak': None if found.peak is None else dict(zip(('omega', 'T'), found.peak, strict=True)),
        'reason': found.reason,
    }
    cautions = [] if found.reason is None else [f'a branch ended early: {found.reason}']
    if found.peak is not None and found.peak[0] > 0.999 * found.high:
        cautions.append(
            f'T is largest at the end of the range, omega {found.high:g}: the resonance has not '
            'come down there, and with this damping may never (a cubic law does not saturate)'
        )
    worst = max((branch.defect for branch in found.branches), default=0.0)
    if worst > ARTEFACT:
        cautions.append(
            f'a motion leaves {worst:.2g} of the drive unbalanced: its branch may be an artefact '
            'of too few harmonics; leave out --harmonics'
        )
    return Answer(
        _title(found.oscillator),
        document,
        _tables(found),
        [response_sheet(found)],
        list(rows(found)),
        cautions,
    )


def write(folder: Path, answer: Answer) -> list[Path]:
    """`response.html`, `.csv`, and each sheet as `.svg` and `.png`."""
    facts = [(k, f'{v:.6g}') for k, v in answer.document['design'].items()]
    parts: list[Part] = [
        header(answer.title, facts),
        *answer.tables,
        *answer.sheets,
        footer(
            'Nondimensional: frequency over sqrt(k1/m), motion over L20 or in rad, vertical '
            'positive downward from the working point. Unstable motions are dashed.'
        ),
    ]
    return [
        write_page(folder / 'response.html', answer.title, parts),
        write_new(folder / 'response.csv', '\n'.join(answer.csv) + '\n'),
        *pictures(folder, answer.sheets),
    ]


def path_document(path: Any, *columns: str) -> dict[str, Any]:
    """Columns (n,) of a path that was followed, and why it ended at either end."""
    document = {name: getattr(path, name).tolist() for name in columns}
    return document | {'ends': [str(end) for end in path.ends]}


def _who(own: Oscillator, omega: tuple[float, float]) -> dict[str, Any]:
    return {
        'schema': 'qzs_rig/frf/1',
        'law': own.law.name,
        'dof': own.dof,
        'zeta': own.zeta,
        'amplitude': own.amplitude,
        'falloff': own.falloff,
        'load': own.load,
        'design': own.design.named,
        'omega': list(omega),
    }


def _branch(branch: Branch) -> dict[str, Any]:
    columns = path_document(branch, 'omega', 'T', 'amplitude', 'phase_deg', 'stable')
    return columns | {'symmetric': branch.symmetric, 'defect': branch.defect}


def _event(event: Any) -> dict[str, Any]:
    names = ('omega', 'T', 'kind', 'amplitude', 'phase_deg', 'branch')
    return {name: getattr(event, name) for name in names}


def _title(own: Oscillator) -> str:
    return f'Frequency response: law {own.law.name}, {own.dof}'


def _tables(found: FrequencyResponse) -> list[Table]:
    own, peak = found.oscillator, found.peak
    facts = [
        ('damping ratio', f'{own.zeta:.6g}'),
        ('base amplitude', f'{own.amplitude:.6g}'),
        ('branches', str(len(found.branches))),
        ('harmonics, at most', str(found.harmonics)),
        ('largest stable T', 'none' if peak is None else f'{peak[1]:.6g} at omega {peak[0]:.6g}'),
        ('isolation onset (T = 1)', ', '.join(f'{w:.8g}' for w in found.onset_omega) or 'none'),
    ]
    events = [
        (
            str(event.branch + 1),
            event.kind.replace('_', ' '),
            f'{event.omega:.10f}',
            f'{event.T:.6g}',
            f'{event.amplitude:.6g}',
        )
        for event in found.events
    ]
    return [
        Table(f'law {own.law.name}, {own.dof}', ('', 'value'), tuple(facts), labels=1),
        Table('branches', BRANCHES, tuple(_branch_rows(found.branches)), labels=1),
        Table('events', ('branch', 'kind', 'omega', 'T', 'amplitude'), tuple(events)),
    ]


BRANCHES = ('branch', 'points', 'omega from', 'to', 'stable', 'largest T', 'ends')


def _branch_rows(branches: Iterable[Branch]) -> Iterable[tuple[str, ...]]:
    for number, b in enumerate(branches):
        yield (
            str(number + 1),
            str(len(b.omega)),
            f'{b.omega.min():.6g}',
            f'{b.omega.max():.6g}',
            f'{100 * float(np.mean(b.stable)):.0f} %',
            f'{b.T.max():.6g}',
            ', '.join(dict.fromkeys(map(str, b.ends))),
        )
