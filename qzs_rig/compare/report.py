"""One self-contained page a run or comparison: curves to explore, tables, facts. No network."""

from __future__ import annotations

import base64
import hashlib
import html
from collections.abc import Sequence
from pathlib import Path

from qzs_rig.compare.events import event_table, events_table
from qzs_rig.compare.panels import Labelled, dofs_of
from qzs_rig.compare.picture import write_picture
from qzs_rig.compare.save import refuse_existing, write_new
from qzs_rig.compare.sections import (
    figure_section,
    header,
    quality_section,
    reading_section,
    table_section,
)
from qzs_rig.compare.skin import BOOT, STYLE
from qzs_rig.compare.tables import Table
from qzs_rig.compare.theory_overlay import TheoryCurve
from qzs_rig.errors import InputError

__all__ = ['event_table', 'report_page', 'write_picture', 'write_report']


def write_report(
    path: Path,
    title: str,
    estimates: Labelled,
    *,
    theory: Sequence[TheoryCurve] = (),
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
    theory: Sequence[TheoryCurve] = (),
    facts: Sequence[tuple[str, str]] = (),
    tables: Sequence[Table] = (),
) -> str:
    """The text of the page. The same input gives the same text; all of it is escaped."""
    plotly = _plotly_script()
    dofs = dofs_of(estimates, theory)
    body = [
        header(title, estimates, facts, dofs),
        table_section(events_table(estimates)),
        *(figure_section(k, dof, estimates, theory) for k, dof in enumerate(dofs)),
        *(table_section(table) for table in tables),
        quality_section(estimates),
        reading_section(estimates, theory),
    ]
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{_policy(plotly, BOOT)}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<link rel="icon" href="data:,">
<title>{html.escape(title)}</title>
<style>{STYLE}</style>
</head>
<body>
<main>
{''.join(body)}</main>
<script>{plotly}</script>
<script>{BOOT}</script>
</body>
</html>
"""


def _plotly_script() -> str:
    try:
        from plotly.offline import get_plotlyjs  # type: ignore[import-untyped, unused-ignore]
    except ImportError as error:
        raise InputError(
            'a report needs the package plotly; install it with: pip install plotly'
        ) from error
    # Spelt so that no string in it ends the script element, and with the line ends a browser
    # hashes.
    return str(get_plotlyjs()).replace('\r\n', '\n').replace('</script', r'<\/script')


def _policy(*scripts: str) -> str:
    """Only these scripts run and nothing is fetched: text from a foreign bag stays text."""
    hashes = (base64.b64encode(hashlib.sha256(s.encode()).digest()).decode() for s in scripts)
    allowed = ' '.join(f"'sha256-{digest}'" for digest in hashes)
    return (
        f"default-src 'none'; script-src {allowed}; style-src 'unsafe-inline'; "
        "img-src data: blob:; font-src data:; base-uri 'none'; form-action 'none'"
    )
