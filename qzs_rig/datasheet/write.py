"""The files of a data sheet: pictures, page, curves. Nothing is overwritten."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path

import numpy as np

from qzs_rig.compare.page import page as html_page
from qzs_rig.compare.sections import header, table_section
from qzs_rig.datasheet.figures import POINTS, SPANS
from qzs_rig.datasheet.summary import Summary
from qzs_rig.drawing.interactive import section
from qzs_rig.drawing.sheet import Sheet
from qzs_rig.files import write_new
from qzs_rig.mechanics import statics
from qzs_rig.report.table import Table
from qzs_rig.units import DOFS

COLUMNS = 'law,dof,x,force,stiffness'


def page(folder: Path, found: Summary, sheets: Sequence[Sheet], tables: Sequence[Table]) -> Path:
    """`statics.html`: tables and interactive figures in one file that needs no network."""
    title = f'Statics: law {found.law.name}'
    facts = [(name, f'{value:.6g}') for name, value in found.design._asdict().items()]
    body = [
        header(title, [], [('law', found.law.source), *facts], []),
        *(table_section(table) for table in tables),
        *(section(sheet) for sheet in sheets),
        '<footer><p>Nondimensional as in the paper: force over k1 L20, torque over k1 L20 L0, '
        'vertical positive downward from the working point. Drag to zoom, double-click to '
        f'return. Source: {escape("Wang et al., Mathematics 2022, 10, 1342")}.</p></footer>\n',
    ]
    path = folder / 'statics.html'
    write_new(path, html_page(title, ''.join(body)).encode())
    return path


def curves(folder: Path, found: Summary) -> Path:
    """`statics.csv`: force with static load, and stiffness, of the law in every motion."""
    lines = [COLUMNS]
    for dof in DOFS:
        x = np.linspace(-SPANS[dof], SPANS[dof], POINTS)
        curve = statics.curve(found.law, found.design, dof, x)
        rows = zip(curve.x.tolist(), curve.force.tolist(), curve.stiffness.tolist(), strict=True)
        lines += [f'{found.law.name},{dof},{x!r},{force!r},{k!r}' for x, force, k in rows]
    path = folder / 'statics.csv'
    write_new(path, ('\n'.join(lines) + '\n').encode())
    return path
