"""`qzs-rig lyapunov`: do neighbouring runs part (chaos) or meet?"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

from qzs_rig.cli import options as shared
from qzs_rig.cli import oscillating
from qzs_rig.files import finite_or_none
from qzs_rig.report.names import dof_name
from qzs_rig.report.sheet import GREY, HUES, Band, Curve, Panel, Points, Sheet
from qzs_rig.report.table import Table, number
from qzs_rig.report.write import csv, npz, pictures
from qzs_rig.theory.motion.batch import Batch
from qzs_rig.theory.motion.chaos import BATCHES, ENOUGH, SURE, Exponents, exponents
from qzs_rig.theory.motion.stroboscope import cheapest_steps


def add_to(verbs: Any) -> None:
    """`lyapunov` on the command line."""
    command = verbs.add_parser(
        'lyapunov',
        help='theory: largest Lyapunov exponent with its standard error',
        description='Largest Lyapunov exponent of runs from rest and from random starts, in units '
        'of omega0: positive for chaos, negative for a motion that settles. The other exponent '
        'is -2 zeta less it.',
    )
    command.add_argument(
        '--starts',
        type=int,
        default=64,
        metavar='N',
        help='runs: the first from rest, the others from random starts (default: 64)',
    )
    command.add_argument(
        '--reach',
        type=float,
        default=1.0,
        metavar='W',
        help='random starts lie within this of rest, in w and dw/dtau (default: 1)',
    )
    command.add_argument('--seed', type=int, default=0, help='of the random starts (default: 0)')
    command.add_argument(
        '--periods', type=int, default=2000, metavar='N', help='length of a run (default: 2000)'
    )
    command.add_argument(
        '--before', type=int, default=500, metavar='N', help='periods to forget (default: 500)'
    )
    command.add_argument(
        '--steps', type=int, metavar='N', help='steps a period (default: chosen for 1e-6)'
    )
    oscillating.add(command, 'folder for figure, CSV and NPZ')
    command.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Run, draw, print."""
    spec, (oscillator,) = oscillating.asked(options)
    dof = oscillator.dof
    omega = oscillating.omega_of(options, spec, oscillator)
    starts = oscillating.at_least(options.starts, 1, '--starts')
    seed = oscillating.at_least(options.seed, 0, '--seed')
    start = np.random.default_rng(seed).uniform(-1.0, 1.0, (2, starts)) * options.reach
    start[:, 0] = 0.0
    reach = min(1.0, 0.5 * oscillator.domain)
    runs = Batch.of(oscillator, omega, w=start[0] * reach, velocity=start[1])
    if options.steps is None:
        steps = cheapest_steps(runs, 1e-6)
    else:
        steps = oscillating.at_least(options.steps, 1, '--steps')
    periods = oscillating.at_least(options.periods, BATCHES, '--periods')
    found = exponents(runs, steps=steps, periods=periods, before=options.before)
    mean, error = found.mean
    document: dict[str, Any] = {
        'dof': dof,
        'law': oscillator.law.name,
        'omega': omega,
        'zeta': oscillator.zeta,
        'amplitude': oscillator.amplitude,
        'steps': steps,
        'periods': periods,
        'exponent': finite_or_none(found.value),
        'standard_error': finite_or_none(found.error),
        'mean': finite_or_none(np.array([mean]))[0],
        'mean_error': finite_or_none(np.array([error]))[0],
        'sum_of_exponents': -2.0 * oscillator.zeta,
        'verdict': verdict(found),
    }
    text = _table(found, dof).to_text() + f'\n\n{document["verdict"]}'
    written: list[Path] = []
    if options.out is not None:
        columns = [runs.w, runs.velocity, found.value, found.error]
        names = ('w', 'velocity', 'exponent', 'standard_error')
        written = [
            *pictures(options.out, [_sheet(found, dof)]),
            csv(options.out, 'lyapunov', names, columns),
            npz(options.out, 'lyapunov', dict(zip(names, columns, strict=True))),
        ]
    shared.show(options, document, text, written)
    return 0


def verdict(found: Exponents) -> str:
    """One line: chaos, cycles, both, or what cannot be told."""
    n = len(found.value)
    if not found.enough.all():
        return (
            f'the runs are too short to tell: they last {found.span:.2g} decay times 1/zeta, and '
            f'a sign takes {ENOUGH:g}; raise --periods'
        )
    chaotic, regular = int(found.chaotic.sum()), int(found.regular.sum())
    lost = int(np.count_nonzero(~np.isfinite(found.value)))
    parts = [
        f'{count} of {n} runs {words}'
        for count, words in (
            (chaotic, 'are chaotic'),
            (regular, 'settle'),
            (lost, 'left the law'),
            (n - chaotic - regular - lost, f'are within {SURE:g} standard errors of zero'),
        )
        if count
    ]
    return '; '.join(parts)


def _extreme(fold: Any, found: Exponents) -> float:
    return float(fold.reduce(found.value))


def _table(found: Exponents, dof: str) -> Table:
    mean, error = found.mean
    rows = [
        ('from rest', number(float(found.value[0]), '.5f'), number(float(found.error[0]), '.1e')),
        ('mean of all runs', number(mean, '.5f'), number(error, '.1e')),
        ('smallest', number(_extreme(np.fmin, found), '.5f'), ''),
        ('largest', number(_extreme(np.fmax, found), '.5f'), ''),
        ('sum of both, -2 zeta', f'{-2.0 * found.runs.zeta[0]:.5f}', ''),
    ]
    omega, runs = found.runs.omega[0], len(found.value)
    caption = f'Lyapunov exponent, {dof_name(dof)}, Omega {omega:.4g}, {runs} runs, '
    caption += f'{found.steps} steps a period'
    return Table(caption, ('', 'exponent', '+-'), tuple(rows), labels=1)


def _sheet(found: Exponents, dof: str) -> Sheet:
    order = np.argsort(found.value)
    x = np.arange(1.0, len(order) + 1.0)
    value, error = found.value[order], found.error[order]
    items = (
        Band('± standard error', x, value - error, value + error, GREY),
        Points('exponent', x, value),
        Curve('zero', x[[0, -1]], np.zeros(2), HUES[1], width=1.0),
    )
    title = f'{dof_name(dof)}, Ω = {found.runs.omega[0]:.4g}'
    panel = Panel(title, 'run, sorted', 'exponent / omega0', items)
    return Sheet('lyapunov', 'Largest Lyapunov exponent', '', (panel,))
