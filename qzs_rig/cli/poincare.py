"""`qzs-rig poincare`: Poincaré map and time history of runs from rest (Figures 15 to 18)."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from qzs_rig.cli import options as shared
from qzs_rig.cli import oscillating
from qzs_rig.files import finite_or_none
from qzs_rig.report.names import dof_name
from qzs_rig.report.sheet import Curve, Panel, Points, Sheet
from qzs_rig.report.table import Table, number
from qzs_rig.report.write import csv, npz, pictures
from qzs_rig.theory.motion.batch import Batch
from qzs_rig.theory.motion.chaos import VISIBLE, Diagram, judged
from qzs_rig.theory.motion.stroboscope import History, history, strobe, strobe_within
from qzs_rig.units import DOFS, TRANSLATIONS

EPILOG = """\
examples:
  qzs-rig poincare --set platform.zeta=0.07 --out fig15   Figures 15 to 18
  qzs-rig poincare --zeta 0.07 --omega 6.28               the same if 6.28 was put in as Omega
  qzs-rig poincare --dof vertical --zeta 0.01 --periods 2000
"""
BLUE, ORANGE, GREY = '#0b62a4', '#f0984f', '#9aa7b1'
DRAWN_STEPS = 48


class Portrait(NamedTuple):
    """One run: seen once a period, judged, and in `steps` a period; the number of periods in which
    its transient shows."""

    dof: str
    diagram: Diagram
    run: History
    visible: int | None
    steps: int


def add_to(verbs: Any) -> None:
    """`poincare` on the command line."""
    command = verbs.add_parser(
        'poincare',
        help='theory: Poincaré map, time history, length of the transient, period',
        description='Runs from rest seen once a period of the base and step by step: which period '
        'they settle into and how long their transient lasts.',
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.add_argument(
        '--periods', type=int, default=500, metavar='N', help='length of a run (default: 500)'
    )
    command.add_argument(
        '--steps', type=int, metavar='N', help='steps a period (default: the fewest for 1e-6)'
    )
    oscillating.add(command, 'folder for figure, CSV and NPZ', dof='all four')
    command.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Run, draw, print."""
    spec, oscillators = oscillating.asked(options, DOFS)
    periods = oscillating.at_least(options.periods, 1, '--periods')
    runs = [Batch.of(own, oscillating.omega_of(options, spec, own)) for own in oscillators]
    portraits = [portrait(run, periods, options.steps) for run in runs]
    document = {'periods': periods, 'runs': [_document(each) for each in portraits]}
    text = '\n\n'.join([_table(portraits, periods).to_text(), *map(_word, portraits)])
    written = _written(options.out, portraits) if options.out is not None else []
    shared.show(options, document, text, written)
    return 0


def portrait(runs: Batch, periods: int, steps: int | None) -> Portrait:
    """The run of `runs`, of one."""
    how: dict[str, Any] = {'periods': periods, 'keep': periods}
    seen = strobe_within(runs, **how) if steps is None else strobe(runs, steps=steps, **how)
    drawn_steps = max(int(seen.steps[0]), DRAWN_STEPS)
    run = history(runs, periods, drawn_steps)
    visible = None
    if seen.period[0] > 0:
        back = seen.w[0, periods - seen.period[0] :]
        cycle = np.resize(back[::-1], periods)[::-1]
        off = np.flatnonzero(np.abs(seen.w[0] - cycle) > VISIBLE)
        visible = int(off[-1]) + 2 if off.size else 0
    return Portrait(runs.dof, judged(seen), run, visible, drawn_steps)


def _document(each: Portrait) -> dict[str, Any]:
    seen = each.diagram.seen
    return {
        'dof': each.dof,
        'omega': float(seen.runs.omega[0]),
        'zeta': float(seen.runs.zeta[0]),
        'amplitude': float(seen.runs.amplitude[0]),
        'steps': int(seen.steps[0]),
        'error': finite_or_none(seen.error)[0],
        'period': int(seen.period[0]),
        'settled': int(seen.settled[0]),
        'transient_visible_periods': each.visible,
        'exponent': finite_or_none(each.diagram.exponent)[0],
        'T': finite_or_none(np.abs(seen.transmissibility))[0],
        'w': finite_or_none(seen.w[0]),
        'velocity': finite_or_none(seen.velocity[0]),
    }


def _table(portraits: list[Portrait], periods: int) -> Table:
    rows = []
    for each in portraits:
        seen = each.diagram.seen
        found = int(seen.period[0])
        rows.append(
            (
                dof_name(each.dof),
                f'{seen.runs.omega[0]:.4g}',
                f'{seen.runs.zeta[0]:.4g}',
                str(found) if found > 0 else {0: 'none yet', -1: 'lost'}[found],
                number(each.visible, 'd') if each.visible is not None else '–',
                str(int(seen.settled[0])) if found > 0 else '–',
                number(float(np.abs(seen.transmissibility[0])), '.4f'),
                number(float(each.diagram.exponent[0]), '.4f'),
                str(int(seen.steps[0])),
            )
        )
    header = ('motion', 'Omega', 'zeta', 'period', 'visible', 'settled', 'T', 'exponent', 'steps')
    caption = f'Runs from rest over {periods} periods; transient visible ({VISIBLE:g}) and settled '
    return Table(caption + '(1e-8) up to that many periods', header, tuple(rows), labels=1)


def _word(each: Portrait) -> str:
    found, name = int(each.diagram.seen.period[0]), dof_name(each.dof)
    if found > 0:
        return (
            f'{name}: settles into period {found}; the transient shows for {each.visible} periods'
        )
    if found < 0:
        return f'{name}: left the law after {int(each.diagram.seen.settled[0])} periods'
    kind, value = each.diagram.kind[0], each.diagram.exponent[0]
    what = {'transient': 'a transient, not chaos', 'chaotic': 'chaos'}.get(kind, 'undecided')
    return f'{name}: has not settled; Lyapunov exponent {value:.4f}: {what}'


def _written(folder: Path, portraits: list[Portrait]) -> list[Path]:
    dofs, cycles, ws, velocities = [], [], [], []
    arrays: dict[str, Any] = {}
    for each in portraits:
        seen = each.diagram.seen
        dofs += [each.dof] * seen.periods
        cycles += list(range(1, seen.periods + 1))
        ws += seen.w[0].tolist()
        velocities += seen.velocity[0].tolist()
        arrays |= {
            f'{each.dof}_tau': each.run.tau,
            f'{each.dof}_w': each.run.w,
            f'{each.dof}_velocity': each.run.velocity,
        }
    columns = [np.array(column) for column in (dofs, cycles, ws, velocities)]
    return [
        *pictures(folder, [_sheet(portraits)]),
        csv(folder, 'poincare', ('dof', 'period', 'w', 'velocity'), columns),
        npz(folder, 'poincare', arrays),
    ]


def _sheet(portraits: list[Portrait]) -> Sheet:
    panels: list[Panel] = []
    for each in portraits:
        seen, unit = each.diagram.seen, 'w / L20' if each.dof in TRANSLATIONS else 'w, rad'
        last = max(int(seen.period[0]), 0) or min(seen.periods, 100)
        once = each.run.w[-each.steps - 1 :], each.run.velocity[-each.steps - 1 :]
        dots = (
            Curve('last period', *once, GREY, width=1.0),
            Points('all periods', seen.w[0], seen.velocity[0], ORANGE, size=2.5),
            Points(f'last {last}', seen.w[0, -last:], seen.velocity[0, -last:], BLUE, size=2.5),
        )
        name = f'{dof_name(each.dof)}, Ω = {seen.runs.omega[0]:.4g}'
        panels.append(Panel(f'{name}: map', unit, 'dw/dτ', dots))
        # as much as shows the transient
        until = seen.periods if each.visible is None else max(12, round(1.5 * each.visible))
        shown = slice(0, until * each.steps + 1)
        turns = each.run.tau[shown] * seen.runs.omega[0] / (2.0 * np.pi)
        wave = Curve('', turns, each.run.w[shown], BLUE, width=1.0)
        panels.append(Panel(f'{name}: history', 'periods', unit, (wave,)))
    return Sheet('poincare', 'Runs from rest seen once a period', '', tuple(panels), columns=2)
