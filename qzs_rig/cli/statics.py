"""`qzs-rig statics`: what the springs do at rest, as numbers, table, figures and curves."""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np

from qzs_rig.cli import options as shared
from qzs_rig.cli import oscillating
from qzs_rig.errors import InputError
from qzs_rig.mechanics import statics
from qzs_rig.mechanics.platform import Platform, platform_design, refuse_coupled_words
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.parameters import RunSpec
from qzs_rig.report import datasheet, statics_figures
from qzs_rig.report.page import Part, footer, header
from qzs_rig.report.table import Table
from qzs_rig.report.write import csv, pictures, write_page
from qzs_rig.samples import Array
from qzs_rig.units import DOFS


def add_to(verbs: Any) -> None:
    """`statics` on the command line."""
    command = verbs.add_parser(
        'statics',
        help='force, stiffness, QZS conditions and load capacity, with figures',
        description='Statics of the platform, nondimensional as in the paper: with --at force and '
        'stiffness at these points, else QZS conditions, soft range, load capacity and Taylor '
        'deviation; with --out figures 9 to 12, an interactive page and the curves as CSV.',
    )
    shared.platform(command, 'the platform')
    oscillating.law(command)
    command.add_argument('--dof', help=f'degree of freedom: {", ".join(DOFS)}')
    command.add_argument(
        '--at',
        metavar='X1,X2,…',
        help='motions over L20, rotations in rad; vertical downward, for instance -0.1,0,0.2',
    )
    command.add_argument(
        '--tolerance',
        type=float,
        default=0.05,
        metavar='K',
        help='stiffness over k1 that counts as quasi-zero (default: 0.05)',
    )
    shared.out(command, 'folder for figures, page and CSV')
    shared.as_json(command)
    command.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Compute, draw, print."""
    spec = oscillating.spec_of(options)
    law = spec.text('platform.law')
    refuse_coupled_words(spec)
    for text in Platform.from_spec(spec).cautions((False,) * len(DOFS)):
        print(f'caution: {text}', file=sys.stderr)
    dof = _known(options.dof, DOFS, 'degree of freedom') if options.dof else None
    if options.at is not None:
        return _points(options, spec, law, dof)
    if not options.tolerance > 0.0:
        raise InputError(f'--tolerance {options.tolerance:g} must be above 0')
    found = datasheet.summary(
        RESTORING[law], platform_design(spec), _force_scale(spec), options.tolerance
    )
    tables = datasheet.tables(found, (dof,) if dof else DOFS)
    document = datasheet.document(found)
    text = '\n\n'.join(table.to_text() for table in tables)
    written = _written(options.out, found, tables) if options.out is not None else []
    shared.show(options, document, text, written)
    return 0


def _points(options: argparse.Namespace, spec: RunSpec, law: str, dof: str | None) -> int:
    if dof is None:
        raise InputError(f'--at needs --dof; give one of {", ".join(DOFS)}')
    if options.out is not None:
        raise InputError('--at prints its points; leave out --out, or leave out --at for figures')
    curve = statics.curve(RESTORING[law], platform_design(spec), dof, _numbers(options.at))
    document: dict[str, Any] = {
        'law': law,
        'dof': dof,
        'units': 'nondimensional',
        'x': curve.x.tolist(),
        'force': curve.force.tolist(),
        'stiffness': curve.stiffness.tolist(),
    }
    if dof == 'vertical' and RESTORING[law].weighted:
        document['static_load'] = curve.static_load
    columns = (curve.x, curve.force, curve.stiffness)
    rows = tuple(tuple(f'{v:.9g}' for v in row) for row in zip(*columns, strict=True))
    table = Table(f'{law}, {dof}', ('x', 'force', 'stiffness'), rows, labels=0)
    shared.show(options, document, table.to_text())
    return 0


def _written(folder: Path, found: datasheet.Summary, tables: list[Table]) -> list[Path]:
    sheets = statics_figures.sheets(found)
    title = f'Statics: law {found.law.name}'
    facts = [(name, f'{value:.6g}') for name, value in found.design.named.items()]
    parts: list[Part] = [
        header(title, [('law', found.law.source), *facts]),
        *tables,
        *sheets,
        footer(
            'Nondimensional as in the paper: force over k1 L20, torque over k1 L20 L0, vertical '
            'positive downward from the working point. Source: Wang et al., Mathematics 2022, '
            '10, 1342.'
        ),
    ]
    return [
        write_page(folder / 'statics.html', title, parts),
        csv(folder, 'statics', *statics_figures.curves(found)),
        *pictures(folder, sheets),
    ]


def _force_scale(spec: RunSpec) -> float:
    """k1 L20 in N."""
    return spec.number('platform.k1') * spec.number('platform.L20')


def _known(name: str, names: tuple[str, ...], what: str) -> str:
    if name not in names:
        raise InputError(f'unknown {what} {name!r}; known: {", ".join(names)}')
    return name


def _numbers(text: str) -> Array:
    values = []
    for word in text.split(','):
        try:
            value = float(word)
        except ValueError:
            raise InputError(
                f'--at {text!r}: {word!r} is not a number; write --at -0.1,0,0.2'
            ) from None
        if not math.isfinite(value):
            raise InputError(f'--at {text!r}: {word!r} is not finite')
        values.append(value)
    return np.array(values)
