"""A figure as files: an interactive page, and pictures where matplotlib is installed."""

from __future__ import annotations

from pathlib import Path

from qzs_rig.compare.picture import write_picture
from qzs_rig.compare.report import write_report
from qzs_rig.paper_figures.measured import Measured


def measured(folder: Path, figure: Measured) -> list[Path]:
    """Files of a figure of measured curves, in `folder`; nothing is overwritten."""
    page = folder / f'{figure.name}.html'
    facts = [('shows', figure.caption)]
    write_report(page, figure.title, figure.estimates, theory=figure.theory, facts=facts)
    paths = [page]
    for kind in ('svg', 'png'):
        paths.append(folder / f'{figure.name}.{kind}')
        write_picture(paths[-1], figure.estimates, theory=figure.theory, title=figure.title)
    return paths
