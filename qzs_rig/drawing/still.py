"""A sheet as SVG or PNG, by matplotlib."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from qzs_rig.compare.look import GRID, INK, QUIET, UNIT_LINE
from qzs_rig.drawing.sheet import Line, Panel, Sheet
from qzs_rig.files import write_new

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PALE = '#a9cbe6'
HUES = ('#0b62a4', '#c2410c', '#1b9e8a', '#7b6cc4', '#8a6d1d', '#5f6b76')
WIDTHS = {1: 7.2, 2: 4.6, 3: 3.8, 4: 3.3}
LINE_WIDTHS = {
    'broad': 4.0,
    'solid': 1.8,
    'dashed': 1.6,
    'dotted': 2.2,
    'marks': 0.0,
    'points': 0.0,
}


def pictures(folder: Path, sheets: Sequence[Sheet]) -> list[Path]:
    """Each sheet as SVG and PNG in `folder`, nothing overwritten.

    Raises ImportError where matplotlib is not installed.
    """
    paths = []
    for sheet in sheets:
        for kind in ('svg', 'png'):
            paths.append(folder / f'{sheet.name}.{kind}')
            write_new(paths[-1], still(sheet, kind))
    return paths


def still(sheet: Sheet, kind: str) -> bytes:
    """The picture of a sheet, `kind` svg or png; the same sheet gives the same bytes.

    Raises ImportError where matplotlib is not installed.
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    rows = -(-len(sheet.panels) // sheet.columns)
    width = WIDTHS[sheet.columns]
    # a fixed salt: the ids inside an SVG are random otherwise
    with rc_context({'font.size': 9.0, 'svg.fonttype': 'path', 'svg.hashsalt': 'qzs_rig'}):
        size = (width * sheet.columns, 0.72 * width * rows + 0.9)
        figure = Figure(figsize=size, layout='constrained')
        figure.suptitle(sheet.title, color=INK, x=0.01, ha='left', fontsize=11.0)
        axes = figure.subplots(rows, sheet.columns, squeeze=False).ravel()
        shared = one_key(sheet)
        for place, panel in zip(axes, sheet.panels, strict=True):
            _panel(place, panel, own_key=not shared)
        if shared:
            handles, labels = axes[0].get_legend_handles_labels()
            below: Any = 'outside lower center'
            figure.legend(handles, labels, loc=below, ncols=4, frameon=False)
        page = io.BytesIO()
        stamp: dict[str, Any] = {'Date': None} if kind == 'svg' else {'Software': None}
        figure.savefig(page, format=kind, dpi=150, metadata=stamp)
    return page.getvalue()


def hue(line: Line) -> str:
    """Colour of a line; paler where it is broad."""
    if line.stroke == 'marks':
        return INK
    return PALE if line.stroke == 'broad' else HUES[line.style % len(HUES)]


def one_key(sheet: Sheet) -> bool:
    """Do all panels name the same lines?"""
    return len({tuple(line.label for line in panel.lines) for panel in sheet.panels}) == 1


def _panel(axes: Axes, panel: Panel, own_key: bool) -> None:
    # the axes through 0, or T = 1 where the scale knows no 0
    axes.axhline(1.0 if 'y' in panel.log else 0.0, color=UNIT_LINE, linewidth=0.8, zorder=0)
    if 'x' not in panel.log:
        axes.axvline(0.0, color=UNIT_LINE, linewidth=0.8, zorder=0)
    for line in panel.lines:
        axes.plot(line.x, line.y, label=line.label or None, color=hue(line), **_stroke(line))
    for name, axis in (('x', axes.xaxis), ('y', axes.yaxis)):
        if name in panel.log:
            _logarithmic(axes, name, axis)
    axes.set_title(panel.title, loc='left', color=INK, fontsize=9.0)
    axes.set_xlabel(panel.x_label)
    axes.set_ylabel(panel.y_label)
    axes.margins(x=0.0)
    axes.grid(True, color=GRID, linewidth=0.8)
    axes.tick_params(colors=QUIET)
    for spine in axes.spines.values():
        spine.set_color(UNIT_LINE)
    if own_key:
        axes.legend(frameon=False, fontsize=8.0)


def _logarithmic(axes: Axes, name: str, axis: Any) -> None:
    """Plain numbers at 1, 2 and 5 of a decade; at its powers alone where there are many."""
    from matplotlib.ticker import LogLocator, NullFormatter

    axes.set(**{f'{name}scale': 'log'})
    low, high = axis.get_view_interval()
    if high < 1e3 * low:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter('{x:g}')
    axis.set_minor_formatter(NullFormatter())


def _stroke(line: Line) -> dict[str, Any]:
    if line.stroke == 'points':
        return {'linestyle': '', 'marker': '.', 'markersize': 1.6, 'markeredgewidth': 0.0}
    dashes = {'dashed': (0, (5, 2)), 'dotted': (0, (1.2, 1.4))}
    if line.stroke == 'marks':
        return {'linestyle': '', 'marker': 'o', 'markersize': 4.5}
    return {'linestyle': dashes.get(line.stroke, '-'), 'linewidth': LINE_WIDTHS[line.stroke]}
