"""The fit drawn: measured points over the fitted branches, phases, residuals."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from qzs_rig.compare.look import GRID, INK, QUIET, UNIT_LINE, hue
from qzs_rig.files import write_new
from qzs_rig.identification.identify import Identified
from qzs_rig.identification.plant import plant
from qzs_rig.identification.residuals import Set
from qzs_rig.report.names import direction_name, dof_name
from qzs_rig.samples import Array
from qzs_rig.theory.balance.response import FrequencyResponse, frequency_response

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MARKERS = {'forward': '>', 'reverse': '<', 'none': 'o'}
MARGIN = 1.05
"""Branches are drawn a little beyond the measured band."""


def written(folder: Path, found: Identified) -> list[Path]:
    """`fit.svg` and `fit.png` in `folder`; raises ImportError where matplotlib is not installed."""
    paths = []
    for kind in ('svg', 'png'):
        paths.append(folder / f'fit.{kind}')
        write_new(paths[-1], drawn(found, kind))
    return paths


def drawn(found: Identified, kind: str) -> bytes:
    """The picture, `kind` svg or png: a column a degree of freedom, the branches settled, the
    points with the lag of their sweep taken off. The same fit gives the same bytes."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    sets = found.fit.sets
    with rc_context({'font.size': 9.0, 'svg.fonttype': 'path', 'svg.hashsalt': 'qzs_rig'}):
        figure = Figure(figsize=(max(6.4, 5.2 * len(sets)), 6.6), layout='constrained')
        heights = (2.2, 1.0, 1.0)
        grid = figure.subplots(3, len(sets), squeeze=False, sharex='col', height_ratios=heights)
        flat = found.fit.trial.residual
        at = 0
        for column, item in zip(grid.T, sets, strict=True):
            n = 2 * len(item.points)
            _column(column, found, item, flat[at : at + n].reshape(2, -1))
            at += n
        page = io.BytesIO()
        stamp: dict[str, Any] = {'Date': None} if kind == 'svg' else {'Software': None}
        figure.savefig(page, format=kind, dpi=150, metadata=stamp)
    return page.getvalue()


def _column(axes: Any, found: Identified, item: Set, residual: Array) -> None:
    magnitude, phase, misses = axes
    _branches(magnitude, phase, found, item)
    points = item.points
    settled = points.magnitude / np.abs(item.lag)
    turned = np.degrees(np.angle(np.exp(1j * points.phase) / item.lag))
    for direction in dict.fromkeys(points.direction.tolist()):
        here = points.direction == direction
        style: dict[str, Any] = {
            'color': hue(0, direction),
            'marker': MARKERS[direction],
            'linestyle': '',
            'markersize': 4,
        }
        use, out = here & item.use, here & ~item.use
        hz, words = points.frequency_hz, direction_name(direction)
        magnitude.plot(hz[use], settled[use], label=words, **style)
        label = f'{words}, left out' if out.any() else None
        magnitude.plot(hz[out], settled[out], markerfacecolor='none', label=label, **style)
        phase.plot(hz[use], turned[use], **style)
        misses.plot(hz[use], residual[0][use], **style)
        misses.plot(hz[use], np.where(points.phased, residual[1], np.nan)[use],
                    markerfacecolor='none', **style)  # fmt: skip
    magnitude.set_title(f'{dof_name(points.dof)}: fitted branches', loc='left', color=INK)
    magnitude.set_yscale('log')
    magnitude.set_ylabel('|T|, top / base')
    magnitude.legend(frameon=False, fontsize=8)
    phase.set_ylabel('phase, °')
    misses.set_ylabel('residual / std\n(open: phase)')
    misses.set_xlabel('frequency, Hz')
    for place, level in ((magnitude, 1.0), (misses, 0.0)):
        place.axhline(level, color=UNIT_LINE, linestyle=':', linewidth=1.2, zorder=0)
    for place in axes:
        _dress(place)


def _dress(axes: Axes) -> None:
    axes.grid(True, color=GRID, linewidth=0.8)
    axes.tick_params(colors=QUIET)
    for spine in axes.spines.values():
        spine.set_color(UNIT_LINE)


def _branches(magnitude: Axes, phase: Axes, found: Identified, item: Set) -> None:
    answer, scale = _response(found, item)
    for branch in answer.branches:
        for stable, dash in ((True, '-'), (False, '--')):
            shown = branch.stable if stable else ~branch.stable
            # a neighbour on either side, so that the two dashes meet
            wide = shown | np.roll(shown, 1) | np.roll(shown, -1) if not stable else shown
            style: dict[str, Any] = {'color': QUIET, 'linestyle': dash, 'linewidth': 1.0}
            magnitude.plot(branch.omega * scale, np.where(wide, branch.T, np.nan), **style)
            turned = np.abs(np.diff(branch.phase_deg, prepend=branch.phase_deg[0])) > 180
            drawn_phase = np.where(wide & ~turned, branch.phase_deg, np.nan)
            phase.plot(branch.omega * scale, drawn_phase, **style)


def _response(found: Identified, item: Set) -> tuple[FrequencyResponse, float]:
    """All branches over the measured band, and what turns Ω into Hz."""
    there = plant(found.spec, item.points.dof)
    omega = there.omega(item.points.frequency_hz)
    low, high = float(omega.min()) / MARGIN, float(omega.max()) * MARGIN
    answer = frequency_response(there.oscillator, low, high, isolas=False)
    return answer, there.omega0 / (2 * np.pi)
