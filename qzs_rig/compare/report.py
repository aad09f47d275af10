"""One self-contained page a run or comparison: curves to explore, tables, facts. No network."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from qzs_rig.compare.events import event_table, events_table
from qzs_rig.compare.page import page
from qzs_rig.compare.panels import Labelled, dofs_of
from qzs_rig.compare.picture import write_picture
from qzs_rig.compare.sections import (
    figure_section,
    header,
    quality_section,
    reading_section,
    table_section,
)
from qzs_rig.files import refuse_existing, write_new
from qzs_rig.prediction.curve import Prediction
from qzs_rig.report.table import Table

__all__ = ['event_table', 'report_page', 'write_picture', 'write_report']


def write_report(
    path: Path,
    title: str,
    estimates: Labelled,
    *,
    theory: Sequence[Prediction] = (),
    facts: Sequence[tuple[str, str]] = (),
    tables: Sequence[Table] = (),
) -> None:
    """Create `path`, an HTML page that needs nothing but itself.

    Raises InputError when the file exists or plotly is not installed.
    """
    refuse_existing(path)
    page = report_page(title, estimates, theory=theory, facts=facts, tables=tables)
    write_new(path, page.encode())


def report_page(
    title: str,
    estimates: Labelled,
    *,
    theory: Sequence[Prediction] = (),
    facts: Sequence[tuple[str, str]] = (),
    tables: Sequence[Table] = (),
) -> str:
    """The text of the page. The same input gives the same text; all of it is escaped."""
    dofs = dofs_of(estimates, theory)
    body = [
        header(title, estimates, facts, dofs),
        table_section(events_table(estimates)),
        *(figure_section(k, dof, estimates, theory) for k, dof in enumerate(dofs)),
        *(table_section(table) for table in tables),
        quality_section(estimates),
        reading_section(estimates, theory),
    ]
    return page(title, ''.join(body))
