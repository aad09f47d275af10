"""The frequencies a run is summed up by, one row a degree of freedom and direction."""

from __future__ import annotations

from collections.abc import Sequence

from qzs_rig.estimation.estimate import Curve, Estimate, Event
from qzs_rig.report.names import direction_order, dof_name, dof_order
from qzs_rig.report.table import MISSING, Table, number

QUANTITIES = ('onset Hz', 'peak Hz', 'peak T', 'jump up Hz', 'jump down Hz', '± Hz')


def events_table(estimates: Sequence[tuple[str, Estimate]]) -> Table:
    """Onset, peak and jumps of every curve; `±` is the spacing of the points they lie between."""
    rows = []
    for label, estimate in estimates:
        for dof, direction in _keys(estimate):
            of = [e for e in estimate.events if (e.dof, e.direction) == (dof, direction)]
            rows.append((label, *_row(dof, direction, of)))
    several = len(estimates) > 1
    header = ('run', 'degree of freedom', 'direction', *QUANTITIES)
    return Table(
        'Isolation onset (T = 1), peak and jumps',
        header if several else header[1:],
        tuple(rows) if several else tuple(row[1:] for row in rows),
        labels=3 if several else 2,
    )


def event_table(estimates: Sequence[tuple[str, Estimate]]) -> str:
    """`events_table` for the terminal."""
    return events_table(estimates).to_text()


def _keys(estimate: Estimate) -> list[tuple[str, str]]:
    items: tuple[Curve | Event, ...] = (*estimate.curves, *estimate.events)
    keys = {(item.dof, item.direction) for item in items}
    return sorted(keys, key=lambda key: (dof_order(key[0]), direction_order(key[1])))


def _row(dof: str, direction: str, events: Sequence[Event]) -> tuple[str, ...]:
    def all_of(kind: str, field: str = 'frequency_hz') -> str:
        values = [number(getattr(event, field)) for event in events if event.kind == kind]
        return ', '.join(values) or MISSING

    resolution = max((event.resolution_hz for event in events), default=None)
    return (
        dof_name(dof),
        direction,
        all_of('onset'),
        all_of('peak'),
        all_of('peak', 'magnitude'),
        all_of('jump_up'),
        all_of('jump_down'),
        number(resolution),
    )
