"""The paper's figures of transmissibility anew: 19 and 20 computed, 22 and 23 measured."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from qzs_rig.claims.paper import ZETA, ZETAS, paper_oscillator
from qzs_rig.claims.transmission import LENGTHS, platform_of_length, swept
from qzs_rig.estimation.estimate import Estimate
from qzs_rig.parameters import RunSpec
from qzs_rig.prediction.curve import Prediction
from qzs_rig.prediction.predict import predict
from qzs_rig.report.names import dof_name
from qzs_rig.report.page import Part, footer, header
from qzs_rig.report.response_page import branch_curves
from qzs_rig.report.run_page import write_picture, write_report
from qzs_rig.report.sheet import Curve, Panel, Sheet, hue
from qzs_rig.report.write import KINDS, drawable, pictures, write_page
from qzs_rig.theory.balance.frequency_response import FrequencyResponse, frequency_response
from qzs_rig.theory.balance.single_term_response import single_term_response
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import DOFS, TRANSLATIONS

LOW, HIGH = 0.03, 3.0
"""Ω; the paper's axes are not in its text."""
LEVEL = 1.0
"""Base acceleration in m/s²: 0.1 m at 0.5 Hz; 0.1 m at 20 Hz, as printed, no shaker does (E12)."""
Solve = Callable[[Oscillator, float, float], FrequencyResponse]


def damping(folder: Path) -> list[Path]:
    """Figure 19: the full law by harmonic balance, then the paper's own Eq (29)."""
    sheets = [
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
    return _computed(folder, sheets)


def length(folder: Path) -> list[Path]:
    """Figure 20: platforms of one shape, L0 and the base motion held."""
    sheet = Sheet(
        'figure_20',
        'Figure 20. Transmissibility over length, law corrected',
        'zeta = 0.07, H = 0.1 m (rotations 5°), L0 = 0.06 m. Unstable motions are dashed.',
        tuple(_over_length(dof) for dof in DOFS),
        columns=2,
    )
    return _computed(folder, [sheet])


def against_linear(folder: Path) -> list[Path]:
    """Figure 22: the QZS platform and its leaf springs alone, forward sweeps."""
    estimates: list[tuple[str, Estimate]] = []
    theory: list[Prediction] = []
    for name, law in (('QZS', 'corrected'), ('leaf springs alone', 'linear')):
        spec, estimate = _run(law)
        estimates.append((name, _forward(estimate)))
        theory += [replace(c, label=f'{c.label}, {name}') for c in predict(spec)]
    title = 'Figure 22. QZS platform and leaf springs alone, forward'
    caption = 'The leaf springs alone isolate from 1.42 Hz, not from 19.32 Hz (E10).'
    return _measured(folder / 'figure_22', title, caption, estimates, theory)


def directions(folder: Path) -> list[Path]:
    """Figure 23: forward and reverse sweep of the QZS platform."""
    spec, estimate = _run('corrected')
    return _measured(
        folder / 'figure_23',
        'Figure 23. QZS platform, forward and reverse',
        'Vertically the two sweeps jump at different frequencies, by a distance that the level '
        'sets; horizontally the spring that pulls back leaves no jump (E4).',
        [('QZS', estimate)],
        list(predict(spec)),
    )


FIGURES: dict[str, Callable[[Path], list[Path]]] = {
    '19': damping,
    '20': length,
    '22': against_linear,
    '23': directions,
}
"""Each writes its files into a folder and names them: a page, and pictures where matplotlib is
installed."""


def _over_damping(dof: str, law: str, solve: Solve) -> Panel:
    curves: list[Curve] = []
    for k, zeta in enumerate(ZETAS):
        found = solve(paper_oscillator(dof, zeta, law), LOW, HIGH)
        curves += branch_curves(found.branches, 'T', f'zeta = {zeta:g}', hue(k))
    return Panel(dof_name(dof), 'Ω', '|u / v|', tuple(curves), 'xy', 1.0)


def _over_length(dof: str) -> Panel:
    curves: list[Curve] = []
    for k, L20 in enumerate(LENGTHS):
        own = platform_of_length(dof, L20)
        found = frequency_response(own, 0.2 / own.omega0, 60.0 / own.omega0)
        curves += branch_curves(found.branches, 'T', f'L20 = {L20:g} m', hue(k), own.omega0)
    text = f'{dof_name(dof)}, zeta = {ZETA:g}'
    return Panel(text, 'ω, rad/s', '|u / v|', tuple(curves), 'xy', 1.0)


def _computed(folder: Path, sheets: Sequence[Sheet]) -> list[Path]:
    parts: list[Part] = [header(sheets[0].title), *sheets, footer()]
    page = write_page(folder / f'{sheets[0].name}.html', sheets[0].title, parts)
    return [page, *pictures(folder, sheets)]


def _run(law: str) -> tuple[RunSpec, Estimate]:
    """The paper's band, slower than its 60 s (E17); both translations at once: the laws keep them
    apart."""
    return swept(law, dict.fromkeys(TRANSLATIONS, LEVEL), 400.0, highest_hz=20.0)


def _forward(estimate: Estimate) -> Estimate:
    return Estimate(
        tuple(curve for curve in estimate.curves if curve.direction == 'forward'),
        tuple(event for event in estimate.events if event.direction == 'forward'),
        estimate.quality,
    )


def _measured(
    path: Path,
    title: str,
    caption: str,
    estimates: Sequence[tuple[str, Estimate]],
    theory: Sequence[Prediction],
) -> list[Path]:
    facts = [('shows', caption)]
    page = path.with_suffix('.html')
    paths = [write_report(page, title, estimates, theory=theory, facts=facts)]
    if drawable():
        for kind in KINDS:
            still = path.with_suffix(f'.{kind}')
            paths.append(write_picture(still, estimates, theory=theory, title=title))
    return paths
