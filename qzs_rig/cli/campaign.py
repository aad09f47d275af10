"""`qzs-rig campaign`: one computation at many points, resumable, on threads or a cluster."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import Any

from qzs_rig import scenario
from qzs_rig.campaign import plan, table_file
from qzs_rig.campaign.finished import quick_look, summary, summary_text
from qzs_rig.campaign.ledger import TABLES
from qzs_rig.campaign.perform import Expected, Performed, expected, perform, points_kept
from qzs_rig.campaign.plan import Plan
from qzs_rig.campaign.runners import Cluster, Threads
from qzs_rig.campaign.tasks import TASKS
from qzs_rig.cli import options as shared
from qzs_rig.cli.options import bar
from qzs_rig.errors import InputError, RunAbortedError
from qzs_rig.files import rewrite
from qzs_rig.report.still import still
from qzs_rig.report.write import drawable

ROOT = Path('campaigns')

DESCRIPTION = """\
Compute one task at every point of a grid or Latin hypercube. Points are worked off in chunks;
each is kept as soon as it is done, so Ctrl-C, a crash or kill -9 loses at most those under way:
the same command goes on where it stopped. The table is the same to the last byte, however many
threads or workers computed it and however often it was interrupted.
"""

EPILOG = """\
a plan:
  campaign:
    task: single_term            # see --list
    sample: grid                 # or latin_hypercube, with samples: 1000 and
                                 #   place: centre, random or maximin
    seed: 7
    chunk: 256                   # points kept together (default: the task's)
  base:                          # what all points share; scenario: NAME lies under it
    platform.law: symmetric
    amplitude: 0.05
  vary:                          # one axis a line; the last runs fastest in a grid
    platform.zeta: {from: 0.0158, to: 0.158, count: 100, scale: log}
    platform.k3_hat: [0.1, 0.5, 1.0]
  options:                       # the task's own settings
    falloff: 0

examples:
  qzs-rig campaign peak_map                        a shipped plan, on all cores
  qzs-rig campaign my.yaml --dry-run               points, time and memory, nothing computed
  qzs-rig campaign my.yaml --scheduler tcp://10.0.0.7:8786
                                                   on a dask.distributed cluster
  python -c "import numpy; print(numpy.load('campaigns/…/table.npz')['peak_T'])"
"""


def add_to(verbs: Any) -> None:
    """`campaign` on the command line."""
    command = verbs.add_parser(
        'campaign',
        help='grids and Latin hypercubes over any parameters; resumable; threads or dask',
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.add_argument(
        'plan', nargs='?', metavar='GRID.yaml', help='a plan: path, or name of a shipped one'
    )
    command.add_argument(
        '--list', action='store_true', help='list tasks with inputs and outputs, and shipped plans'
    )
    command.add_argument('--dry-run', action='store_true', help='say what it would take, and end')
    command.add_argument('--workers', type=int, metavar='N', help='threads (default: one a core)')
    command.add_argument(
        '--scheduler', metavar='tcp://…', help='run on the workers of this dask scheduler'
    )
    command.add_argument(
        '--format', choices=table_file.FORMATS, help='of the table (default: parquet with pyarrow)'
    )
    command.add_argument('--no-picture', action='store_true', help='leave out the quick look')
    shared.assignments(command)
    shared.out(command, 'folder of the campaign (default: campaigns/<plan>_<fingerprint>)')
    shared.as_json(command)
    command.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Plan, compute, tell; 1 where every point failed."""
    if options.list:
        return _list(options)
    if options.plan is None:
        raise InputError(f'name a plan; known: {", ".join(plan.shipped())}, or a YAML file')
    path = plan.find(options.plan)
    wanted = plan.load(path, scenario.assigned(options.assignments))
    folder = options.out or ROOT / f'{path.stem}_{wanted.fingerprint}'
    runner = _runner(options)
    said = _told(wanted, folder, runner)
    print(said, file=sys.stdout if options.dry_run and not options.json else sys.stderr)
    if options.dry_run:
        if options.json:
            shared.show(options, {'points': wanted.points, 'plan': wanted.document}, '')
        return 0
    done = _performed(options, wanted, folder, runner)
    return _tell(options, wanted, done, path.stem)


def _runner(options: argparse.Namespace) -> Threads | Cluster:
    if options.scheduler:
        if options.workers is not None:
            raise InputError('--workers is for threads here; a cluster brings its own workers')
        return Cluster(options.scheduler)
    if options.workers is not None and options.workers < 1:
        raise InputError(f'--workers {options.workers} must be 1 or more')
    return Threads(options.workers or os.cpu_count() or 1)


def _performed(
    options: argparse.Namespace, wanted: Plan, folder: Path, runner: Threads | Cluster
) -> Performed:
    progress = bar(wanted.points, 'points', wanted.task.name)
    at: int | None = None

    def show(points: int) -> None:
        nonlocal at
        if at is None:
            progress.initial = points  # what was found says nothing about the speed
        progress.update(points - (at or 0))
        at = points

    try:
        return perform(wanted, folder, runner, options.format, show)
    except KeyboardInterrupt:
        raise RunAbortedError(
            f'stopped with {points_kept(wanted, folder)} of {wanted.points} points kept in '
            f'{folder}; the same command goes on from there'
        ) from None
    finally:
        progress.close()


def _told(wanted: Plan, folder: Path, runner: Threads | Cluster) -> str:
    """What will be computed, and what it will take; nothing where it is done already."""
    if any((folder / name).is_file() for name in TABLES):
        return f'folder   {folder} holds all {wanted.points} points already'
    costs = expected(wanted, runner.ahead)
    axes = [f'vary     {axis.parameter.name}: {axis.text}' for axis in wanted.sample.axes]
    return '\n'.join(
        [
            f'plan     {wanted.task.name}, {wanted.sample.text}, seed {wanted.seed}',
            *axes,
            f'points   {wanted.points} in {wanted.chunks} chunks of {wanted.chunk}, '
            f'{_bytes(wanted.chunk_bytes)} of figures each',
            f'time     {_time(wanted, costs, runner)}',
            f'memory   {_bytes(costs.memory)} beside the program; table {_bytes(costs.table)}',
            f'folder   {folder}',
        ]
    )


def _time(wanted: Plan, costs: Expected, runner: Threads | Cluster) -> str:
    share = f'{_seconds(costs.point_s)} a point on one thread here'
    if isinstance(runner, Cluster):
        whole = f'{_seconds(costs.point_s * wanted.points)} of one core, shared by {runner.text}'
    else:
        # points in Python alternate: threads gain where a kernel releases the interpreter
        low = costs.point_s * wanted.points / runner.workers
        whole = f'from {_seconds(low)} on {runner.text}'
    return f'{whole} ({share}, timed on {costs.timed})'


def _tell(options: argparse.Namespace, wanted: Plan, done: Performed, name: str) -> int:
    found = summary(done.table)
    files = {'table': str(done.table.path)}
    look = None if options.no_picture else _picture(wanted, done, name)
    if look:
        files['quick_look'] = str(look)
    document = {
        **found,
        'plan': wanted.document,
        'kept_before': done.kept,
        'first_s': done.first_s,
        'wall_s': done.wall_s,
        'files': files,
    }
    lines = [summary_text(found), '']
    if done.damaged:
        print(f'caution: {done.damaged} damaged chunks were computed again', file=sys.stderr)
    if done.kept:
        lines.append(f'resumed  {done.kept} of {wanted.points} points were there already')
    if done.first_s is not None:
        speed = (wanted.points - done.kept) / done.wall_s
        lines.append(
            f'took     {done.wall_s:.2f} s, {speed:.0f} points/s, first chunk after '
            f'{done.first_s:.2f} s'
        )
    lines += [f'wrote    {file}' for file in files.values()]
    shared.show(options, document, '\n'.join(lines))
    return 1 if found['failed'] == found['points'] else 0


def _picture(wanted: Plan, done: Performed, name: str) -> Path | None:
    path = done.table.path.with_name('quick_look.png')
    if path.exists():
        return path
    if not drawable():
        return None
    sheet = quick_look(wanted, done.table, f'{name}: {wanted.task.text}')
    rewrite(path, still(sheet, 'png'))
    return path


def _list(options: argparse.Namespace) -> int:
    plans = plan.shipped()
    lines = ['shipped plans', *(f'  {name:20}{text}' for name, text in plans.items()), '']
    tasks: dict[str, Any] = {}
    for task in TASKS.values():
        rows = [
            *(('input', p.name, p.unit, f'{p.text} ({p.range_text})') for p in task.inputs),
            *(('option', p.name, p.unit, f'{p.text} (default {p.default})') for p in task.options),
            *(('output', o.name, o.unit, o.text) for o in task.outputs),
        ]
        keys = ('kind', 'name', 'unit', 'text')
        tasks[task.name] = {
            'text': task.text,
            'chunk': task.chunk,
            'columns': [dict(zip(keys, row, strict=True)) for row in rows],
        }
        lines.append(f'{task.name}: {task.text}; chunks of {task.chunk} points')
        lines += [
            f'  {kind:7}{name + (f" ({unit})" if unit else ""):26}{text}'
            for kind, name, unit, text in rows
        ]
        lines.append('')
    lines.append('inputs besides: every parameter of qzs-rig scenarios --parameters')
    shared.show(options, {'plans': plans, 'tasks': tasks}, '\n'.join(lines))
    return 0


def _seconds(value: float) -> str:
    for scale, unit in ((1.0, 's'), (1e-3, 'ms')):
        if value >= scale:
            return f'{value / scale:.3g} {unit}'
    return f'{value / 1e-6:.3g} µs'


def _bytes(value: float) -> str:
    return f'{value / 1e6:.3g} MB' if value >= 1e5 else f'{value / 1e3:.3g} kB'
