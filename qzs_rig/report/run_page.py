"""The page and the picture of runs: their curves over theory, their events, what was seen."""

from __future__ import annotations

import json
from collections.abc import Sequence
from html import escape
from pathlib import Path

from qzs_rig.errors import InputError
from qzs_rig.estimation.estimate import Curve, Estimate, Event
from qzs_rig.files import refuse_existing, write_new
from qzs_rig.prediction.curve import Prediction
from qzs_rig.report.names import direction_order, dof_name, dof_order
from qzs_rig.report.page import footer, header, page
from qzs_rig.report.still import still
from qzs_rig.report.table import MISSING, Table, number
from qzs_rig.report.transmissibility import Labelled, dof_sheet, dofs_of, overview
from qzs_rig.report.write import KINDS

QUANTITIES = ('onset Hz', 'peak Hz', 'peak T', 'jump up Hz', 'jump down Hz', '± Hz')
CONVENTIONS = (
    'T is the amplitude of the top plate over that of the base plate; the platform isolates where '
    'T < 1. The phase is that of the top against the base, negative when it lags. THD is the root '
    "sum square of the top's harmonics over its fundamental."
)
ABOUT_THEORY = (
    'Theory: solid where the motion is stable, dashed where it is not, an arrow where a sweep '
    'cannot go on and jumps up or down. A measured point is on the stable branch nearest in T, on '
    'none farther than a factor of 2; σ is the stated uncertainty of the point, the band about a '
    'curve two of it.'
)


def write_report(
    path: Path,
    title: str,
    estimates: Labelled,
    *,
    theory: Sequence[Prediction] = (),
    facts: Sequence[tuple[str, str]] = (),
    tables: Sequence[Table] = (),
) -> Path:
    """Create `path`, an HTML page that needs nothing but itself.

    Raises InputError when the file exists or Bokeh is not installed.
    """
    refuse_existing(path)
    page = report_page(title, estimates, theory=theory, facts=facts, tables=tables)
    return write_new(path, page)


def report_page(
    title: str,
    estimates: Labelled,
    *,
    theory: Sequence[Prediction] = (),
    facts: Sequence[tuple[str, str]] = (),
    tables: Sequence[Table] = (),
) -> str:
    """The text of the page. The same input gives the same text; all of it is escaped."""
    sheets = [
        dof_sheet(dof, estimates, theory, f'figure-{k}')
        for k, dof in enumerate(dofs_of(estimates, theory))
    ]
    used = sorted({(curve.estimator, curve.quantity) for _, e in estimates for curve in e.curves})
    sources = '; '.join(f'{name} ({quantity})' for name, quantity in used)
    return page(
        title,
        [
            header(title, facts, ' · '.join(label for label, _ in estimates), sheets),
            events_table(estimates),
            *sheets,
            *tables,
            _quality(estimates),
            footer(
                CONVENTIONS,
                f'Estimated by: {sources}.' if sources else '',
                ABOUT_THEORY if theory else '',
            ),
        ],
    )


def write_picture(
    path: Path,
    estimates: Labelled,
    *,
    theory: Sequence[Prediction] = (),
    dofs: Sequence[str] = (),
    title: str = '',
) -> Path:
    """Create `path` (.svg or .png): one column a degree of freedom (`dofs`, or all there are),
    magnitude over phase. The same input gives the same bytes.

    Raises InputError when the file exists, its suffix is another, or matplotlib is not installed.
    """
    kind = path.suffix[1:]
    if kind not in KINDS:
        raise InputError(f'{path} is no picture; end its name in .{" or .".join(KINDS)}')
    refuse_existing(path)
    names = list(dofs) or dofs_of(estimates, theory)
    if not names:
        raise InputError(f'{path} would be empty: the estimates have no curve')
    return write_new(path, still(overview(path.stem, title, names, estimates, theory), kind))


def events_table(estimates: Labelled) -> Table:
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


def _quality(estimates: Labelled) -> str:
    """What each estimator said about its input, folded away."""
    parts = [
        f'<h3>{escape(label)}</h3>'
        f'<pre>{escape(json.dumps(estimate.quality, indent=2, default=str))}</pre>'
        for label, estimate in estimates
        if estimate.quality
    ]
    if not parts:
        return ''
    return (
        '<section class="card"><details><summary>What the estimator saw</summary>'
        f'{"".join(parts)}</details></section>\n'
    )
