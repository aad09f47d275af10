"""`qzs-rig basin`: which motion every start leads to, and how little it takes to jump."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

from qzs_rig.cli import options as shared
from qzs_rig.cli import oscillating
from qzs_rig.cli.options import bar
from qzs_rig.errors import InputError, RigError
from qzs_rig.files import finite_or_none, number_or_none
from qzs_rig.report.names import dof_name
from qzs_rig.report.sheet import Curve, Panel, Regions, Sheet, hue
from qzs_rig.report.table import Table, number
from qzs_rig.report.write import csv, npz, pictures
from qzs_rig.theory.motion.basin import LOST, UNSETTLED, Basin, JumpMargin, basin, jump_margin
from qzs_rig.theory.oscillator import Oscillator

NO_OTHER = 'no kick or rise leads to a motion whose T differs by more than 5 %'

EPILOG = """\
examples:
  qzs-rig basin --dof vertical --zeta 0.02 --omega 0.305 --out basin
  qzs-rig basin vertical_sweep --omega 0.8
  qzs-rig basin --law taylor --zeta 0.07 --omega 0.4 --w -2:2 --velocity -2:2
  qzs-rig basin --zeta 0.07 --amplitude 0.1667 --margin 0.72:1.05 --points 12
"""


def add_to(verbs: Any) -> None:
    """`basin` on the command line."""
    command = verbs.add_parser(
        'basin',
        help='theory: basins of attraction, and the margin to a jump',
        description='Runs from a grid of starts, relative motion and velocity where the base is at '
        'its highest: which motions they settle into. With --margin the smallest kick and the '
        'smallest rise of the level that make the run from rest jump, per frequency.',
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.add_argument('--w', default='-2:2', metavar='LO:HI', help='starts (default: -2:2)')
    command.add_argument(
        '--velocity', default='-2:2', metavar='LO:HI', help='starts, dw/dtau (default: -2:2)'
    )
    command.add_argument(
        '--grid', type=int, default=120, metavar='N', help='starts each way (default: 120)'
    )
    command.add_argument(
        '--margin', metavar='LO:HI', help='jump margin over these Omega, instead of the grid'
    )
    command.add_argument(
        '--points', type=int, default=24, metavar='N', help='frequencies of --margin (default: 24)'
    )
    command.add_argument(
        '--kick', type=float, default=2.0, metavar='V', help='largest kick tried (default: 2)'
    )
    command.add_argument(
        '--rise', type=float, default=4.0, metavar='R', help='largest level rise (default: 4)'
    )
    command.add_argument(
        '--periods', type=int, default=1000, metavar='N', help='longest run (default: 1000)'
    )
    oscillating.add(command, 'folder for figure, CSV and NPZ')
    command.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Run, draw, print."""
    spec, (oscillator,) = oscillating.asked(options)
    dof = oscillator.dof
    if options.margin is not None:
        return _margin(options, oscillator)
    omega = oscillating.omega_of(options, spec, oscillator)
    n = oscillating.at_least(options.grid, 2, '--grid')
    found = basin(
        oscillator,
        omega,
        np.linspace(*oscillating.pair(options.w, '--w'), n),
        np.linspace(*oscillating.pair(options.velocity, '--velocity'), n),
        periods=oscillating.at_least(options.periods, 1, '--periods'),
    )
    document = _document(found, oscillator)
    text = _table(found, dof).to_text()
    written = _written(options.out, found, dof) if options.out is not None else []
    shared.show(options, document, text, written)
    return 0


def _document(found: Basin, oscillator: Oscillator) -> dict[str, Any]:
    return {
        'dof': oscillator.dof,
        'law': oscillator.law.name,
        'omega': found.omega,
        'zeta': oscillator.zeta,
        'amplitude': oscillator.amplitude,
        'steps': found.steps,
        'periods': found.periods,
        'w': found.w.tolist(),
        'velocity': found.velocity.tolist(),
        'which': found.which.tolist(),
        'attractors': [_finite(vars(each)) for each in found.attractors],
        'lost_share': float(np.mean(found.which == LOST)),
        'unsettled_share': float(np.mean(found.which == UNSETTLED)),
    }


def _finite(values: dict[str, Any]) -> dict[str, Any]:
    """null for the T of a base at rest."""
    return {name: number_or_none(value) for name, value in values.items()}


def _table(found: Basin, dof: str) -> Table:
    rows = [
        (
            str(k),
            f'{100.0 * each.share:.1f}',
            str(each.period),
            f'{each.T:.4f}',
            f'{each.phase_deg:.1f}',
            f'{each.low:.4f}',
            f'{each.high:.4f}',
        )
        for k, each in enumerate(found.attractors)
    ]
    for word, number_ in (('left the law', LOST), ('not settled', UNSETTLED)):
        share = 100.0 * float(np.mean(found.which == number_))
        if share:
            rows.append((word, f'{share:.1f}', '', '', '', '', ''))
    caption = f'Motions of {dof_name(dof)} at Omega {found.omega:.4g}, by share of the starts '
    caption += f'({found.which.size} runs, {found.steps} steps a period)'
    header = ('motion', 'share %', 'period', 'T', 'phase deg', 'lowest w', 'highest w')
    return Table(caption, header, tuple(rows), labels=1)


def _written(folder: Path, found: Basin, dof: str) -> list[Path]:
    grid = np.meshgrid(found.w, found.velocity)
    names = ('w', 'velocity', 'motion')
    columns = (grid[0].ravel(), grid[1].ravel(), found.which.ravel())
    arrays = {'w': found.w, 'velocity': found.velocity, 'which': found.which}
    return [
        *pictures(folder, [_sheet(found, dof)]),
        csv(folder, 'basin', names, columns),
        npz(folder, 'basin', arrays),
    ]


def _sheet(found: Basin, dof: str) -> Sheet:
    names = {
        k: (f'{k}: T = {each.T:.3f}, period {each.period}', hue(k))
        for k, each in enumerate(found.attractors[:12])
    }
    for word, number_, colour in (('left', LOST, '#22303c'), ('not settled', UNSETTLED, '#c9d1d8')):
        if (found.which == number_).any():
            names[number_] = (word, colour)
    regions = Regions(found.w, found.velocity, found.which, names)
    title = f'{dof_name(dof)}, Ω = {found.omega:.4g}'
    panel = Panel(title, 'w at the highest base', 'dw/dτ', (regions,))
    return Sheet('basin', 'Basins of attraction', '', (panel,))


def _margin(options: argparse.Namespace, oscillator: Oscillator) -> int:
    if options.omega is not None or options.frequency is not None:
        raise InputError('--margin names the frequencies; leave out --omega and --frequency')
    low, high = oscillating.pair(options.margin, '--margin')
    for word, value, least in (
        ('--margin', low, 0.0),
        ('--kick', options.kick, 0.0),
        ('--rise', options.rise, 1.0),
    ):
        if not least < value < np.inf:
            raise InputError(f'{word} {value:g}: give a number above {least:g}')
    omegas = np.linspace(low, high, oscillating.at_least(options.points, 2, '--points'))
    found: list[JumpMargin | None] = []
    reasons: list[str] = []
    with bar(float(len(omegas)), 'frequencies', 'jump margin') as progress:
        for omega in omegas.tolist():
            try:
                found.append(
                    jump_margin(
                        oscillator,
                        omega,
                        largest_kick=options.kick,
                        largest_rise=options.rise,
                        periods=options.periods,
                    )
                )
                reasons.append('' if found[-1] and found[-1].other else NO_OTHER)
            except RigError as error:
                found.append(None)
                reasons.append(str(error))
            progress.update(1)
    columns = {
        'omega': omegas,
        'T': np.array([each.now.T if each else np.nan for each in found]),
        'other_T': np.array([each.other.T if each and each.other else np.nan for each in found]),
        'kick': np.array([each.kick if each else np.nan for each in found]),
        'kick_phase_deg': np.array([each.kick_phase_deg if each else np.nan for each in found]),
        'rise': np.array([each.rise if each else np.nan for each in found]),
    }
    document: dict[str, Any] = {'dof': oscillator.dof, 'law': oscillator.law.name}
    document |= {name: finite_or_none(column) for name, column in columns.items()}
    document['reason'] = reasons
    rows = tuple(
        tuple(number(float(value), '.4f') for value in row)
        for row in zip(*columns.values(), strict=True)
    )
    caption = 'Smallest kick of dw/dtau and smallest level factor that make the run from rest jump'
    text = Table(caption, tuple(columns), rows, labels=0).to_text()
    for omega, reason in zip(omegas.tolist(), reasons, strict=True):
        if reason:
            text += f'\n\nomega {omega:.4g}: {reason}'
    written: list[Path] = []
    if options.out is not None:
        kicks = (Curve('kick', omegas, columns['kick'], hue(0), width=1.0),)
        rises = (Curve('level factor', omegas, columns['rise'], hue(1), width=1.0),)
        panels = (
            Panel(f'{dof_name(oscillator.dof)}: kick', 'Ω', 'smallest dw/dτ', kicks),
            Panel(f'{dof_name(oscillator.dof)}: level', 'Ω', 'smallest factor', rises),
        )
        written = [
            *pictures(options.out, [Sheet('margin', 'Margin', '', panels, columns=2)]),
            csv(options.out, 'margin', tuple(columns), list(columns.values())),
            npz(options.out, 'margin', columns),
        ]
    shared.show(options, document, text, written)
    return 0
