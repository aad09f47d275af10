"""Figures 19 and 20: transmissibility over damping and length, every branch with its stability."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from qzs_rig.claims.settling import AMPLITUDE, TURN, ZETA
from qzs_rig.claims.transmission import LENGTHS, ZETAS, platform_of_length
from qzs_rig.drawing.response_sheet import shown
from qzs_rig.drawing.sheet import Line, Panel, Sheet
from qzs_rig.mechanics.design import PAPER_DESIGN
from qzs_rig.report.names import dof_name
from qzs_rig.theory.balance.response import FrequencyResponse, frequency_response
from qzs_rig.theory.balance.single_term_response import single_term_response
from qzs_rig.theory.oscillator import Oscillator, oscillator
from qzs_rig.units import DOFS, TRANSLATIONS

LOW, HIGH = 0.03, 3.0
"""Ω; the paper's axes are not in its text."""
Solve = Callable[[Oscillator, float, float], FrequencyResponse]


def damping() -> list[Sheet]:
    """Figure 19: the full law by harmonic balance, then the paper's own Eq (29)."""
    return [
        Sheet(
            name,
            f'Figure 19. Transmissibility over damping, {words}',
            'Ĥ = 0.6 (rotations 5°). Unstable motions are dashed.',
            tuple(_over_damping(dof, law, solve) for dof in DOFS),
            columns=2,
        )
        for name, words, law, solve in (
            ('figure_19', 'law corrected', 'corrected', frequency_response),
            ('figure_19_single_term', 'Eq (29)', 'symmetric', single_term_response),
        )
    ]


def length() -> list[Sheet]:
    """Figure 20: platforms of one shape, L0 and the base motion held."""
    return [
        Sheet(
            'figure_20',
            'Figure 20. Transmissibility over length, law corrected',
            'zeta = 0.07, H = 0.1 m (rotations 5°), L0 = 0.06 m. Unstable motions are dashed.',
            tuple(_over_length(dof) for dof in DOFS),
            columns=2,
        )
    ]


def _over_damping(dof: str, law: str, solve: Solve) -> Panel:
    amplitude = AMPLITUDE if dof in TRANSLATIONS else TURN
    lines: list[Line] = []
    for style, zeta in enumerate(ZETAS):
        own = oscillator(law, dof, PAPER_DESIGN, zeta, amplitude)
        lines += _lines(f'zeta = {zeta:g}', solve(own, LOW, HIGH), style, 1.0)
    return Panel(dof_name(dof), 'Ω', '|u / v|', tuple(lines), 'xy')


def _over_length(dof: str) -> Panel:
    lines: list[Line] = []
    for style, L20 in enumerate(LENGTHS):
        own, omega0 = platform_of_length(dof, L20)
        found = frequency_response(own, 0.2 / omega0, 60.0 / omega0)
        lines += _lines(f'L20 = {L20:g} m', found, style, omega0)
    text = f'{dof_name(dof)}, zeta = {ZETA:g}'
    return Panel(text, 'ω, rad/s', '|u / v|', tuple(lines), 'xy')


def _lines(label: str, found: FrequencyResponse, style: int, scale: float) -> Iterator[Line]:
    """All branches in one colour, named once."""
    for stable, stroke in ((True, 'solid'), (False, 'dashed')):
        for branch in found.branches:
            own = shown(branch, stable)
            if own.any():
                T = np.where(own, branch.T, np.nan)
                yield Line(label, branch.omega * scale, T, style, stroke)
                label = ''
