"""A figure as files: an interactive page, and pictures where matplotlib is installed."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

from qzs_rig.compare.page import page
from qzs_rig.compare.picture import write_picture
from qzs_rig.compare.report import write_report
from qzs_rig.compare.sections import header
from qzs_rig.drawing.interactive import section
from qzs_rig.drawing.sheet import Sheet
from qzs_rig.drawing.still import pictures
from qzs_rig.files import write_new
from qzs_rig.paper_figures.measured import Measured


def measured(folder: Path, figure: Measured) -> list[Path]:
    """Files of a figure of measured curves, in `folder`; nothing is overwritten."""
    paths = [folder / f'{figure.name}.html']
    facts = [('shows', figure.caption)]
    write_report(paths[0], figure.title, figure.estimates, theory=figure.theory, facts=facts)
    if find_spec('matplotlib'):
        for kind in ('svg', 'png'):
            paths.append(folder / f'{figure.name}.{kind}')
            write_picture(paths[-1], figure.estimates, theory=figure.theory, title=figure.title)
    return paths


def computed(folder: Path, sheets: Sequence[Sheet]) -> list[Path]:
    """Files of a figure of computed curves, all its sheets on one page."""
    name = sheets[0].name
    body = [header(sheets[0].title, [], [], []), *(section(sheet) for sheet in sheets)]
    paths = [folder / f'{name}.html']
    write_new(paths[0], page(sheets[0].title, ''.join(body)).encode())
    return paths + (pictures(folder, sheets) if find_spec('matplotlib') else [])
