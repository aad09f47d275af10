"""The fit as a sheet: measured points over the fitted branches, phases, residuals."""

from __future__ import annotations

import numpy as np

from qzs_rig.identification.identify import Identified
from qzs_rig.identification.residuals import Set
from qzs_rig.report.names import direction_name, dof_name
from qzs_rig.report.response_page import branch_curves
from qzs_rig.report.sheet import QUIET, Curve, Item, Panel, Points, Sheet
from qzs_rig.report.transmissibility import ARROWS, FREQUENCY, MAGNITUDE, PHASE, hue
from qzs_rig.samples import Array
from qzs_rig.theory.balance.response import FrequencyResponse, frequency_response
from qzs_rig.theory.oscillator import Oscillator

MARGIN = 1.05
"""Branches are drawn a little beyond the measured band."""


def fit_sheet(found: Identified) -> Sheet:
    """A column a degree of freedom: the branches settled, the points with the lag of their sweep
    taken off."""
    columns = []
    at = 0
    for item in found.fit.sets:
        n = 2 * len(item.points)
        residual = found.fit.trial.residual[at : at + n].reshape(2, -1)
        columns.append(_column(found, item, residual))
        at += n
    panels = tuple(panel for row in zip(*columns, strict=True) for panel in row)
    return Sheet('fit', 'Fitted platform', '', panels, columns=len(columns), linked=True)


def _column(found: Identified, item: Set, residual: Array) -> tuple[Panel, Panel, Panel]:
    points = item.points
    answer, scale = _response(found, item)
    settled = points.magnitude / np.abs(item.lag)
    turned = np.degrees(np.angle(np.exp(1j * points.phase) / item.lag))
    magnitude: list[Item] = [*_fitted(answer, 'T', scale)]
    phase: list[Item] = [*_fitted(answer, 'phase_deg', scale)]
    misses: list[Item] = []
    for direction in dict.fromkeys(points.direction.tolist()):
        here = points.direction == direction
        use, out = here & item.use, here & ~item.use
        words, phased = direction_name(direction), use & points.phased
        for items, label, y, where, hollow in (
            (magnitude, words, settled, use, False),
            (magnitude, f'{words}, left out', settled, out, True),
            (phase, words, turned, use, False),
            (misses, words, residual[0], use, False),
            (misses, f'{words}, phase', residual[1], phased, True),
        ):
            if where.any():
                mark = ARROWS.get(direction, 'dot')
                f, colour = points.frequency_hz[where], hue(0, direction)
                items.append(Points(label, f, y[where], colour, mark, 4.0, hollow))
    title = f'{dof_name(points.dof)}: fitted branches'
    about = 'residual / std\n(open: phase)'
    return (
        Panel(title, FREQUENCY, MAGNITUDE, tuple(magnitude), 'y', 1.0, height=0.6),
        Panel('', FREQUENCY, PHASE, tuple(phase), height=0.3),
        Panel('', FREQUENCY, about, tuple(misses), level=0.0, height=0.3),
    )


def _fitted(answer: FrequencyResponse, what: str, scale: float) -> list[Curve]:
    return list(branch_curves(answer.branches, what, 'fit', QUIET, scale, 1.0))


def _response(found: Identified, item: Set) -> tuple[FrequencyResponse, float]:
    """All branches over the measured band, and what turns Ω into Hz."""
    there = Oscillator.driven(found.spec, item.points.dof)
    omega = there.omega(item.points.frequency_hz)
    low, high = float(omega.min()) / MARGIN, float(omega.max()) * MARGIN
    answer = frequency_response(there, low, high, isolas=False)
    return answer, there.hertz
