"""`qzs-rig bifurcation`: what runs settle into as a parameter varies (Figures 13 and 14)."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from qzs_rig.cli import options as shared
from qzs_rig.cli import oscillating
from qzs_rig.cli.options import bar
from qzs_rig.errors import InputError
from qzs_rig.files import finite_or_none
from qzs_rig.parameters import RunSpec
from qzs_rig.report.names import dof_name
from qzs_rig.report.sheet import Panel, Points, Sheet
from qzs_rig.report.table import Table
from qzs_rig.report.write import csv, npz, pictures
from qzs_rig.samples import Array
from qzs_rig.theory.motion.batch import RATIOS, SLANT, batch_along
from qzs_rig.theory.motion.chaos import KINDS, Diagram, carried, from_rest
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import DOFS

RANGES = {'zeta': '0.0158:0.158', SLANT: '0.1:1', 'amplitude': '0.02:1', 'omega': '0.05:2'}
"""Figure 13, Figure 14, and what is of interest beyond them."""

HUES = {
    'periodic': '#0b62a4',
    'transient': '#f0984f',
    'chaotic': '#b83280',
    'undecided': '#8795a1',
    'lost': '#3f4d58',
}

EPILOG = """\
examples:
  qzs-rig bifurcation --out fig13                     Figure 13: damping, all four motions
  qzs-rig bifurcation --vary L20 --out fig14          Figure 14: length of the suspension springs
  qzs-rig bifurcation --omega 6.28 --dof vertical     Figure 13 if 6.28 was put in as Omega
  qzs-rig bifurcation --vary omega --from previous    sweep up and down, jumps and all
  qzs-rig bifurcation vertical_sweep --vary omega --from previous    over the band of a run
  qzs-rig bifurcation --vary platform.k3 --range 500:8000 --dof vertical

A point is transient, not chaotic, where its Lyapunov exponent is negative though its kept points
scatter: wait, and it becomes a cycle. Ratios vary alone; L20 and platform.… hold the base motion
in m and rad/s, and L20 holds L1/L20.
"""


class Part(NamedTuple):
    """One diagram of the command."""

    dof: str
    way: str
    values: Array
    diagram: Diagram


def add_to(verbs: Any) -> None:
    """`bifurcation` on the command line."""
    command = verbs.add_parser(
        'bifurcation',
        help='theory: periodic, transient or chaotic, as a parameter varies',
        description='Runs seen once a period of the base over a range of one parameter: the '
        'period they settle into, what is only an undecayed transient, and Lyapunov exponents '
        'where the points leave a doubt.',
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.add_argument(
        '--vary',
        default='zeta',
        metavar='NAME',
        help=f'{", ".join(RATIOS)}, {SLANT} or platform.… (default: zeta)',
    )
    command.add_argument(
        '--range',
        metavar='LO:HI',
        help='its range (default: as in the paper; of omega the band of SCENARIO)',
    )
    command.add_argument('--points', type=int, default=300, metavar='N', help='default: 300')
    command.add_argument(
        '--from',
        dest='start',
        choices=('rest', 'previous'),
        default='rest',
        help='start every run at rest, or where the one before it ended, up and down '
        '(default: rest)',
    )
    command.add_argument(
        '--periods', type=int, default=500, metavar='N', help='length of a run (default: 500)'
    )
    command.add_argument(
        '--keep', type=int, default=400, metavar='N', help='last periods drawn (default: 400)'
    )
    command.add_argument(
        '--steps',
        type=int,
        metavar='N',
        help='steps a period, 1000 in the paper (default: the fewest that keep --error)',
    )
    command.add_argument(
        '--error', type=float, default=1e-6, metavar='E', help='what w may be off (default: 1e-6)'
    )
    command.add_argument(
        '--whole',
        action='store_true',
        help='integrate every period, also of runs that repeat themselves',
    )
    oscillating.add(command, 'folder for figure, CSV and NPZ', dof='all four')
    command.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Run, draw, print."""
    if getattr(options, options.vary, None) is not None:
        raise InputError(f'--vary {options.vary} and --{options.vary} both name it; keep one')
    spec, oscillators = oscillating.asked(options, DOFS)
    parts = [part for own in oscillators for part in _parts(options, spec, own)]
    document = {
        'parameter': options.vary,
        'periods': options.periods,
        'keep': options.keep,
        'diagrams': [_document(part, options.keep) for part in parts],
    }
    text = '\n\n'.join(
        [_table(options.vary, parts).to_text(), *_words(options.vary, parts, options.error)]
    )
    written = _written(options.out, options.vary, parts) if options.out is not None else []
    shared.show(options, document, text, written)
    return 0


def _values(options: argparse.Namespace, spec: RunSpec, own: Oscillator) -> Array:
    """(n,) values of what is varied."""
    points = oscillating.at_least(options.points, 2, '--points')
    band = oscillating.band_of(options, spec, own)
    if options.vary == 'omega' and band and not options.range:
        return np.linspace(*band, points)
    words = options.range or RANGES.get(options.vary)
    if words is None:
        raise InputError(f'--vary {options.vary} needs --range LO:HI')
    return np.linspace(*oscillating.pair(words, '--range'), points)


def _parts(options: argparse.Namespace, spec: RunSpec, own: Oscillator) -> Iterator[Part]:
    """The diagram from rest, or those up and down."""
    how = {
        'periods': options.periods,
        'keep': options.keep,
        'early': not options.whole,
        'steps': options.steps,
    }
    values = _values(options, spec, own)
    omega = 1.0 if options.vary == 'omega' else oscillating.omega_of(options, spec, own)
    runs = batch_along(spec, own, omega, options.vary, values)
    if options.start == 'rest':
        yield Part(own.dof, 'from rest', values, from_rest(runs, options.error, **how))
        return
    for way, order in (('up', slice(None)), ('down', slice(None, None, -1))):
        with bar(float(len(values)), 'runs', f'{dof_name(own.dof)}, {way}') as progress:

            def tell(done: int, progress: Any = progress) -> None:
                progress.update(done - progress.n)

            found = carried(runs[order], options.error, progress=tell, **how)
        yield Part(own.dof, way, values[order], found)


def _document(part: Part, keep: int) -> dict[str, Any]:
    seen = part.diagram.seen
    shown = np.where(seen.period > 0, np.minimum(seen.period, keep), min(keep, 32))
    return {
        'dof': part.dof,
        'from': part.way,
        'values': part.values.tolist(),
        'omega': seen.runs.omega.tolist(),
        'steps': seen.steps.tolist(),
        'error': finite_or_none(seen.error),
        'kind': part.diagram.kind.tolist(),
        'period': seen.period.tolist(),
        'settled': seen.settled.tolist(),
        'exponent': finite_or_none(part.diagram.exponent),
        'exponent_error': finite_or_none(part.diagram.exponent_error),
        'T': finite_or_none(np.abs(seen.transmissibility)),
        'w': [finite_or_none(w[len(w) - n :]) for w, n in zip(seen.w, shown, strict=True)],
    }


def _table(name: str, parts: list[Part]) -> Table:
    rows = []
    for part in parts:
        seen = part.diagram.seen
        omega = _span(seen.runs.omega)
        steps = f'{seen.steps.min()}–{seen.steps.max()}'
        for kind in KINDS:
            mine = part.diagram.kind == kind
            if not mine.any():
                continue
            found = np.unique(seen.period[mine & (seen.period > 0)])
            exponent = part.diagram.exponent[mine]
            rows.append(
                (
                    dof_name(part.dof),
                    part.way,
                    kind,
                    str(int(mine.sum())),
                    _span(part.values[mine]),
                    ' '.join(map(str, found)),
                    '' if np.isnan(exponent).all() else _span(exponent),
                    omega,
                    steps,
                )
            )
    header = ('motion', 'runs', 'kind', 'points', name, 'periods', 'exponent', 'Omega', 'steps')
    return Table(f'Runs over {name}', header, tuple(rows), labels=3)


def _words(name: str, parts: list[Part], wanted: float) -> list[str]:
    said = []
    for part in parts:
        diagram = part.diagram
        late = (diagram.kind == 'transient') & (diagram.seen.period > 0)
        if late.any():
            left_out = diagram.seen.periods - diagram.seen.w.shape[1]
            said.append(
                f'{dof_name(part.dof)}, {part.way}: settled, but only after up to '
                f'{int(diagram.seen.settled[late].max())} periods, later than the {left_out} left '
                f'out, at {int(late.sum())} of {len(late)} points ({name} '
                f'{_span(part.values[late])})'
            )
        late = (diagram.kind == 'transient') & (diagram.seen.period == 0)
        if late.any():
            said.append(
                f'{dof_name(part.dof)}, {part.way}: transient, not chaos, at {int(late.sum())} of '
                f'{len(late)} points ({name} {_span(part.values[late])}): the last '
                f'{diagram.seen.w.shape[1]} of {diagram.seen.periods} periods still scatter, yet '
                f'the largest Lyapunov exponent there is {np.nanmax(diagram.exponent[late]):.4g}'
            )
        error = diagram.seen.error
        if np.isfinite(error).any():
            over = int(np.count_nonzero(error > wanted))
            said.append(
                f'{dof_name(part.dof)}, {part.way}: error of w by finer steps up to '
                f'{np.nanmax(error):.1e}'
                + (
                    f', above {wanted:g} at {over} points: chaos, or the border of two motions'
                    if over
                    else ''
                )
            )
    return said


def _written(folder: Path, name: str, parts: list[Part]) -> list[Path]:
    columns: dict[str, list[Any]] = {key: [] for key in ('dof', 'from', name, 'kind', 'w')}
    arrays: dict[str, Any] = {}
    for part in parts:
        tag, seen = f'{part.dof}_{part.way}'.replace(' ', '_'), part.diagram.seen
        x, y, kind = _points(part)
        columns['dof'] += [part.dof] * len(x)
        columns['from'] += [part.way] * len(x)
        columns[name] += x.tolist()
        columns['kind'] += kind.tolist()
        columns['w'] += y.tolist()
        arrays |= {
            f'{tag}_{name}': part.values,
            f'{tag}_w': seen.w,
            f'{tag}_velocity': seen.velocity,
            f'{tag}_period': seen.period,
            f'{tag}_settled': seen.settled,
            f'{tag}_exponent': part.diagram.exponent,
            f'{tag}_kind': part.diagram.kind,
        }
    lists = [np.array(column) for column in columns.values()]
    return [
        *pictures(folder, [_sheet(name, parts)]),
        csv(folder, 'bifurcation', list(columns), lists),
        npz(folder, 'bifurcation', arrays),
    ]


def _sheet(name: str, parts: list[Part]) -> Sheet:
    panels = []
    for part in parts:
        x, y, what = _points(part)
        dots = tuple(
            Points(word, x[what == word], y[what == word], hue, size=2.5)
            for word, hue in HUES.items()
            if (what == word).any()
        )
        unit = 'w / L20' if part.diagram.seen.runs.number < 2 else 'w, rad'
        omega = _span(part.diagram.seen.runs.omega)
        title = f'{dof_name(part.dof)}, {part.way}, Ω = {omega}'
        panels.append(Panel(title, name, f'{unit} once a period', dots))
    title = f'Runs seen once a period over {name}'
    return Sheet('bifurcation', title, '', tuple(panels), columns=min(2, len(panels)))


def _points(part: Part) -> tuple[Array, Array, Any]:
    """What a diagram shows: the points of a cycle once, all that were kept otherwise."""
    seen, keep = part.diagram.seen, part.diagram.seen.w.shape[1]
    settled = part.diagram.kind == 'periodic'
    n = np.where(settled, np.minimum(np.maximum(seen.period, 1), keep), keep)
    mask = np.arange(keep)[None, :] >= keep - n[:, None]
    mask &= np.isfinite(seen.w)
    return (
        np.broadcast_to(part.values[:, None], mask.shape)[mask],
        seen.w[mask],
        np.broadcast_to(part.diagram.kind[:, None], mask.shape)[mask],
    )


def _span(values: Array) -> str:
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    return f'{low:.4g}' if high - low <= 1e-9 * abs(high) else f'{low:.4g}–{high:.4g}'
