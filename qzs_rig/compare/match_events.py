"""How far the events of two runs lie from each other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from qzs_rig.compare.match_curves import Direction, joint, paired_directions
from qzs_rig.estimation.estimate import Estimate, Event
from qzs_rig.report.names import dof_name, event_name
from qzs_rig.report.table import Table, number


@dataclass(frozen=True)
class EventDifference:
    """One event as seen by `a` and by `b`; None where one of them has no such event.

    `difference_hz` is b - a; `resolution_hz` the coarser spacing of the two, so that a difference
    below it means nothing.
    """

    dof: str
    direction: str
    kind: str
    a: str
    b: str
    a_hz: float | None
    b_hz: float | None
    difference_hz: float | None
    a_magnitude: float | None
    b_magnitude: float | None
    magnitude_percent: float | None
    resolution_hz: float
    note: str = ''


def event_differences(
    a: tuple[str, Estimate], b: tuple[str, Estimate]
) -> Iterator[EventDifference]:
    """Every event of the labelled estimates, paired nearest first or noted as alone."""
    for dof, of_a, of_b in paired_directions(a[1], b[1]):
        for kind in dict.fromkeys(event.kind for event in (*a[1].events, *b[1].events)):
            ones, twos = _events(a[1], dof, of_a, kind), _events(b[1], dof, of_b, kind)
            for one, two in _nearest_first(ones, twos):
                yield _row((dof, joint(of_a, of_b), kind), (a[0], one), (b[0], two))


def event_difference_table(rows: Sequence[EventDifference]) -> Table:
    """`rows` for the eye."""
    header = ('degree of freedom', 'direction', 'event', 'a', 'b', 'a Hz', 'b Hz', 'b - a Hz')
    return Table(
        'Events of b against a',
        (*header, '± Hz', 'a T', 'b T', 'ΔT %', 'remark'),
        tuple(
            (
                dof_name(row.dof),
                row.direction,
                event_name(row.kind),
                row.a,
                row.b,
                number(row.a_hz),
                number(row.b_hz),
                number(row.difference_hz, '+.3f'),
                number(row.resolution_hz),
                number(row.a_magnitude),
                number(row.b_magnitude),
                number(row.magnitude_percent, '+.2f'),
                row.note,
            )
            for row in rows
        ),
        labels=5,
    )


def _events(estimate: Estimate, dof: str, direction: Direction, kind: str) -> list[Event]:
    key = (dof, direction, kind)
    return [e for e in estimate.events if (e.dof, e.direction, e.kind) == key]


def _nearest_first(
    ones: Sequence[Event], twos: Sequence[Event]
) -> list[tuple[Event | None, Event | None]]:
    """Pairs by the smallest difference of frequency, then those left over beside None."""
    distances = sorted(
        (abs(one.frequency_hz - two.frequency_hz), i, j)
        for i, one in enumerate(ones)
        for j, two in enumerate(twos)
    )
    partner: dict[int, int] = {}
    for _, i, j in distances:
        if i not in partner and j not in partner.values():
            partner[i] = j
    pairs: list[tuple[Event | None, Event | None]] = [
        (one, twos[partner[i]] if i in partner else None) for i, one in enumerate(ones)
    ]
    return pairs + [(None, two) for j, two in enumerate(twos) if j not in partner.values()]


def _row(
    key: tuple[str, str, str], a: tuple[str, Event | None], b: tuple[str, Event | None]
) -> EventDifference:
    one, two = a[1], b[1]
    both = one is not None and two is not None
    return EventDifference(
        *key,
        a[0],
        b[0],
        a_hz=one.frequency_hz if one else None,
        b_hz=two.frequency_hz if two else None,
        difference_hz=two.frequency_hz - one.frequency_hz if one and two else None,
        a_magnitude=one.magnitude if one else None,
        b_magnitude=two.magnitude if two else None,
        magnitude_percent=100 * (two.magnitude / one.magnitude - 1) if one and two else None,
        resolution_hz=max(event.resolution_hz for event in (one, two) if event),
        note='' if both else f'only in {a[0] if one else b[0]}',
    )
