"""The figure as a still picture, for a README or a paper; needs matplotlib."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from qzs_rig.compare.look import (
    ARROWS,
    FOLD_MARKS,
    GRID,
    INK,
    QUIET,
    UNIT_LINE,
    event_mark,
    hue,
    line_width,
    theory_hue,
)
from qzs_rig.compare.panels import (
    Labelled,
    Ranges,
    Shown,
    arrow_indices,
    dofs_of,
    phase_line,
    ranges,
    shown,
    theory_line,
)
from qzs_rig.errors import InputError
from qzs_rig.files import refuse_existing, write_new
from qzs_rig.prediction.curve import Prediction
from qzs_rig.report.names import direction_name, dof_name

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis

FORMATS = ('.svg', '.png')


def write_picture(
    path: Path,
    estimates: Labelled,
    *,
    theory: Sequence[Prediction] = (),
    dofs: Sequence[str] = (),
    title: str = '',
) -> None:
    """Create `path` (.svg or .png): one column a degree of freedom (`dofs`, or all there are),
    magnitude over phase. The same input gives the same bytes.

    Raises InputError when the file exists, its suffix is another, or matplotlib is not installed.
    """
    if path.suffix not in FORMATS:
        raise InputError(f'{path} is no picture; end its name in {" or ".join(FORMATS)}')
    refuse_existing(path)
    names = list(dofs) or dofs_of(estimates, theory)
    if not names:
        raise InputError(f'{path} would be empty: the estimates have no curve')
    write_new(path, _drawn(names, estimates, theory, title, path.suffix[1:]))


def _drawn(
    dofs: Sequence[str],
    estimates: Labelled,
    theory: Sequence[Prediction],
    title: str,
    kind: str,
) -> bytes:
    try:
        from matplotlib import rc_context
        from matplotlib.figure import Figure
    except ImportError as error:
        raise InputError(
            'a picture needs the package matplotlib; install it with: pip install matplotlib'
        ) from error
    # A fixed salt: the ids inside an SVG are random otherwise.
    with rc_context({'font.size': 9.0, 'svg.fonttype': 'path', 'svg.hashsalt': 'qzs_rig'}):
        figure = Figure(figsize=(max(6.4, 4.6 * len(dofs)), 5.2), layout='constrained')
        figure.suptitle(_plain(title), color=INK)
        axes = figure.subplots(2, len(dofs), squeeze=False, sharex='col', height_ratios=(2.2, 1.0))
        for column, dof in zip(axes.T, dofs, strict=True):
            _column(column[0], column[1], dof, estimates, theory)
        sheet = io.BytesIO()
        stamp: dict[str, Any] = {'Date': None} if kind == 'svg' else {'Software': None}
        figure.savefig(sheet, format=kind, dpi=160, metadata=stamp)
    return sheet.getvalue()


def _column(
    magnitude: Axes, phase: Axes, dof: str, estimates: Labelled, theory: Sequence[Prediction]
) -> None:
    curves = shown(dof, estimates)
    predictions = [curve for curve in theory if curve.dof == dof]
    magnitude.axhline(1.0, color=UNIT_LINE, linestyle=':', linewidth=1.2, zorder=0)
    for item in curves:
        _curve(magnitude, phase, item, len(estimates) > 1)
    for k, prediction in enumerate(predictions):
        _theory(magnitude, phase, prediction, theory_hue(k))
    _dress(magnitude, phase, ranges([item.curve for item in curves], predictions))
    magnitude.set_title(_plain(dof_name(dof)), loc='left', color=INK)
    if curves or predictions:
        magnitude.legend(frameon=False, fontsize=8)


def _theory(magnitude: Axes, phase: Axes, theory: Prediction, colour: str) -> None:
    for stable, dash in ((True, '-'), (False, '--')):
        line = theory_line(theory, stable)
        if line.frequency_hz.size:
            label = theory.label + ('' if stable else ', unstable')
            style: dict[str, Any] = {'color': colour, 'linestyle': dash, 'linewidth': 0.8}
            magnitude.plot(line.frequency_hz, line.magnitude, label=_plain(label), **style)
            phase.plot(line.frequency_hz, line.phase_deg, **style)
    for fold in theory.folds:
        mark = FOLD_MARKS[fold.kind].matplotlib
        style = {'color': colour, 'marker': mark, 'markersize': 9, 'linestyle': ''}
        magnitude.plot(fold.frequency_hz, fold.transmissibility[0], **style)


def _curve(magnitude: Axes, phase: Axes, item: Shown, several: bool) -> None:
    curve, colour = item.curve, hue(item.item, item.curve.direction)
    width = 0.8 * line_width(curve.direction)
    words = direction_name(curve.direction)
    label = f'{item.label}, {words}' if several else words
    magnitude.plot(
        curve.frequency_hz, curve.magnitude, color=colour, linewidth=width, label=_plain(label)
    )
    arrow = ARROWS.get(curve.direction)
    if arrow:
        at = np.array(arrow_indices(curve), dtype=np.intp)
        style: dict[str, Any] = {
            'color': colour,
            'marker': arrow.matplotlib,
            'linestyle': '',
            'markersize': 5,
        }
        magnitude.plot(curve.frequency_hz[at], curve.magnitude[at], **style)
    line = phase_line(curve)
    phase.plot(line.frequency_hz, line.phase_deg, color=colour, linewidth=width)
    for event in item.events:
        magnitude.plot(
            event.frequency_hz,
            event.magnitude,
            marker=event_mark(event.kind).matplotlib,
            markersize=7,
            markerfacecolor='white',
            markeredgecolor=colour,
            markeredgewidth=1.6,
            linestyle='',
            clip_on=False,
            zorder=5,
        )


def _dress(magnitude: Axes, phase: Axes, view: Ranges) -> None:
    magnitude.set_yscale('log')
    magnitude.set_ylim(*view.magnitude)
    _ticks(magnitude.yaxis, view.magnitude)
    magnitude.set_ylabel('|T|, top / base')
    phase.set_ylim(*view.phase_deg)
    phase.set_yticks(np.arange(-180, view.phase_deg[1], 90))
    phase.set_ylabel('phase, °')
    phase.set_xlabel('frequency, Hz')
    if view.log_frequency:
        phase.set_xscale('log')
        _ticks(phase.xaxis, view.frequency_hz)
    phase.set_xlim(*view.frequency_hz)
    for axes in (magnitude, phase):
        axes.grid(True, color=GRID, linewidth=0.8)
        axes.tick_params(colors=QUIET)
        for spine in axes.spines.values():
            spine.set_color(UNIT_LINE)


def _ticks(axis: Axis, span: tuple[float, float]) -> None:
    """Plain numbers at 1, 2, 5; powers of ten where those would crowd."""
    low, high = span
    digits = (1, 2, 5) if high < 1e3 * low else (1,)
    ticks = [digit * 10.0**power for power in range(-6, 7) for digit in digits]
    within = [tick for tick in ticks if low <= tick <= high]
    axis.set_ticks(within, [f'{tick:g}' for tick in within])
    axis.set_ticks([], minor=True)


def _plain(text: str) -> str:
    """`text` without matplotlib's markup: dollars would be mathematics, a leading _ hides it."""
    return ' ' * text.startswith('_') + text.replace('$', r'\$')
