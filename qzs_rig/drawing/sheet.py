"""What a figure of computed curves holds; how it is drawn is another matter."""

from __future__ import annotations

from typing import NamedTuple

from qzs_rig.samples import Array


class Line(NamedTuple):
    """One curve; `style` counts colours, `stroke` is broad, solid, dashed, dotted, marks, or points
    (many and small).

    A line without a label is not named in the key.
    """

    label: str
    x: Array
    y: Array
    style: int
    stroke: str = 'solid'


class Panel(NamedTuple):
    """One pair of axes; `log` names those that are logarithmic: '', 'x', 'y' or 'xy'."""

    title: str
    x_label: str
    y_label: str
    lines: tuple[Line, ...]
    log: str = ''


class Sheet(NamedTuple):
    """One figure, numbered as in the paper where it has one; panels row by row."""

    name: str
    title: str
    caption: str
    panels: tuple[Panel, ...]
    columns: int
