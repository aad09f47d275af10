"""C10 to C14: transmissibility over damping and length, isolation onset, and sweeps of the rig."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache

import numpy as np

from qzs_rig import scenario
from qzs_rig.claims.paper import (
    AMPLITUDE,
    BASE,
    TURN,
    ZETA,
    ZETAS,
    Verdict,
    paper_oscillator,
)
from qzs_rig.estimation.estimate import Estimate
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import PAPER_DESIGN
from qzs_rig.parameters import RunSpec
from qzs_rig.run import in_process
from qzs_rig.theory.balance.frequency_response import FrequencyResponse, frequency_response
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.theory.single_term import folds, single_term
from qzs_rig.units import DOFS, TRANSLATIONS

LENGTHS = (0.1, 0.6, 1.0)
"""L20 of Figure 20, m."""
LOW, HIGH = 0.02, 3.0
"""Range of Ω."""
LEVELS = (0.5, 4.0)
"""Base acceleration in m/s²: a level at which the plate moves little, and the default run's."""
INTERVALS = {'vertical': 0.32, 'horizontal': 0.31}
SETTLED = 0.02
"""Part of the onset that lag of the sweep shifts it by, each way: measured without any jump."""


def damping() -> Verdict:
    """C10: Figure 19 by the paper's own balance (29), peaks of the full law beside it."""
    figures, lowers, raises, removes = {}, [], [], []
    for dof in TRANSLATIONS:
        c1, c3 = RESTORING['symmetric'].cubic(PAPER_DESIGN)[DOFS.index(dof)]
        peaks, above = [], []
        for zeta in ZETAS:
            found = response(paper_oscillator(dof, zeta))
            peaks.append(found.peak[1] if found.peak else math.nan)
            above.append(float(single_term(c1, c3, zeta, AMPLITUDE, HIGH).T[0, 0]))
            jumps = folds(c1, c3, zeta, AMPLITUDE)
            figures[f'{dof}, zeta = {zeta:g}: peak T, law corrected'] = peaks[-1]
            figures[f'{dof}, zeta = {zeta:g}: T at Ω = {HIGH:g} by (29)'] = above[-1]
            figures[f'{dof}, zeta = {zeta:g}: folds of (29)'] = float(len(jumps))
        removes.append(len(jumps) == 0)
        lowers.append(peaks == sorted(peaks, reverse=True))
        raises.append(above == sorted(above))
    return Verdict(
        'Fig 19: more damping lowers the peak, raises T where T < 1, and removes the jump',
        all(lowers) and all(raises) and all(removes),
        figures,
        'Ĥ = 0.6. Peaks fall and T above them rises, but with (29) a fold remains at zeta = 0.158: '
        'without saturation the upper branch of so large an amplitude never comes down at all; '
        'qzs-rig figures 19',
    )


def length() -> Verdict:
    """C11: Figure 20 with H held: peak, and where isolation begins, rad/s."""
    figures, falls, stays = {}, [], []
    for dof in DOFS:
        peaks, starts = [], []
        for L20 in LENGTHS:
            own = platform_of_length(dof, L20)
            found = response(own)
            peaks.append(found.peak[1] if found.peak else math.nan)
            starts.append(isolation(found) * own.omega0)
            figures[f'{dof}, L20 = {L20:g} m: peak T'] = peaks[-1]
            figures[f'{dof}, L20 = {L20:g} m: isolates from rad/s'] = starts[-1]
        falls.append(peaks == sorted(peaks, reverse=True))
        down = starts == sorted(starts, reverse=True)
        same = np.ptp(starts) < 0.05 * np.mean(starts)
        stays.append(down if dof in TRANSLATIONS else bool(same))
    return Verdict(
        'Fig 20: a longer L20 lowers peak and isolation onset (displacement), only the peak '
        '(rotation)',
        all(falls) and all(stays),
        {name: value for name, value in figures.items() if math.isfinite(value)},
        'law corrected, zeta = 0.07, H = 0.1 m or 5° and L0 held (with Ĥ held the translations do '
        'not know L20): so it is for both translations and for vertical rotation; horizontal '
        'rotation tips at small L20, where k3 < A L0 (E7); qzs-rig figures 20',
    )


def onset() -> Verdict:
    """C12: the lowest and the highest frequency from which T stays below 1, over omega0."""
    figures, within = {}, []
    for dof in DOFS:
        found = response(paper_oscillator(dof))
        start = isolation(found)
        figures[f'{dof}: isolates from, over omega0'] = start
        within.append(0.1 <= start <= 0.2)
    return Verdict(
        'isolation begins at 0.1 to 0.2 of the natural frequency: about 2 to 4 Hz',
        all(within),
        figures,
        'law corrected, zeta = 0.07, Ĥ = 0.6 or 5°, forward sweep: in the rotations it does, in '
        'the translations the large motion is as stiff as 1 + A; omega0 is 3.18 Hz, so 0.1 to 0.2 '
        'of it would be 0.32 to 0.64 Hz (E8); qzs-rig frf',
    )


def interval() -> Verdict:
    """C13: onset of the forward sweep less onset of the reverse one, translations, two levels."""
    figures, differ, right = {}, [], []
    for dof in TRANSLATIONS:
        for level in LEVELS:
            forward, reverse = swept_onset('corrected', dof, level)
            figures[f'{dof}, {level:g} m/s², Hz'] = gap = forward - reverse
            differ.append(gap > 2.0 * SETTLED * forward)
            right.append(abs(gap - INTERVALS[dof]) < 0.1)
    return Verdict(
        'forward and reverse sweeps differ: jump interval 0.32 Hz (vertical), 0.31 Hz (horizontal)',
        all(differ) and all(right),
        figures,
        'onset of the forward less onset of the reverse sweep of rig runs, law corrected: '
        'vertically they differ, by an interval that grows with the level; horizontally the stiff '
        "suspension springs leave no jump (E4). 0.32 Hz is the paper's own resolution (E15); "
        'qzs-rig figures 23',
    )


def against_linear() -> Verdict:
    """C14: vertical onset of the QZS platform and of the leaf springs alone."""
    linear = max(swept_onset('linear', 'vertical', LEVELS[0]))
    figures = {'leaf springs alone, Hz': linear}
    below = []
    for level in LEVELS:
        forward, reverse = swept_onset('corrected', 'vertical', level)
        figures[f'QZS forward, {level:g} m/s², Hz'] = forward
        figures[f'QZS reverse, {level:g} m/s², Hz'] = reverse
        below.append(forward < 0.5 * linear)
    return Verdict(
        "the QZS mode's isolation onset is far below the linear mode's (2.22 against 19.32 Hz)",
        all(below),
        figures,
        'rig runs; the leaf springs alone have their onset at sqrt(2) times 1.007 Hz (E10), and '
        'the QZS onset rises with the level, past it at 4 m/s²; qzs-rig figures 22',
    )


def platform_of_length(dof: str, L20: float) -> Oscillator:
    """One motion of a platform of the paper's shape with another L20 (m), on the paper's base."""
    given = {'platform.L20': L20, 'platform.L1_hat': PAPER_DESIGN.L1, 'platform.zeta': ZETA}
    own = Oscillator.of(scenario.of(given), dof, 0.0)
    return own.under(BASE if dof in TRANSLATIONS else TURN, 'displacement')


def response(own: Oscillator) -> FrequencyResponse:
    """The branches that a sweep from either end of the range follows."""
    return frequency_response(own, LOW, HIGH, isolas=False)


def isolation(found: FrequencyResponse) -> float:
    """Ω from which a forward sweep stays below T = 1: its onset, or the jump down that passes it;
    NaN where there is neither."""
    falls = [fold.omega for fold in found.folds if fold.T > 1.0]
    return max([*found.onset_omega, *falls], default=math.nan)


@cache
def swept_onset(law: str, dof: str, level: float) -> tuple[float, float]:
    """Isolation onset in Hz, forward and reverse, of a slow sweep of acceleration `level`; NaN
    where T crosses 1 nowhere."""
    levels = {name: level * (name == dof) for name in TRANSLATIONS}
    _, estimate = swept(law, levels, 300.0)
    found = {
        event.direction: event.frequency_hz
        for event in estimate.events
        if event.kind == 'onset' and event.dof == dof
    }
    return found.get('forward', math.nan), found.get('reverse', math.nan)


def swept(
    law: str, levels: Mapping[str, float], duration: float, highest_hz: float = 4.0
) -> tuple[RunSpec, Estimate]:
    """A logarithmic sweep there and back of base accelerations `levels` in m/s² from the paper's
    0.5 Hz up, `duration` s; below the shaker's 1 Hz as the paper's is (E12)."""
    spec = scenario.load('vertical_sweep').override(
        {
            'platform.law': law,
            'excitation.frequency_low': 0.5,
            'excitation.frequency_high': highest_hz,
            'excitation.duration': duration,
            'shaker.limits': False,
            **{f'excitation.amplitude.{dof}': level for dof, level in levels.items()},
        }
    )
    return spec, in_process.run(spec).estimate
