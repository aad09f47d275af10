"""`qzs-rig figures`: the paper's figures of transmissibility, drawn by the rig."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from qzs_rig.claims.paper_figures import FIGURES
from qzs_rig.cli import options as shared
from qzs_rig.cli.options import bar
from qzs_rig.errors import InputError
from qzs_rig.files import refuse_existing


def add_to(verbs: Any) -> None:
    """`figures` on the command line."""
    command = verbs.add_parser(
        'figures',
        help="the paper's figures of transmissibility, computed and measured anew",
        description="Draw the paper's figures of transmissibility: 19 and 20 by harmonic balance, "
        '22 and 23 as runs of the rig over theory; a page, SVG and PNG each. Figures 9 to 12 come '
        'from qzs-rig statics, 13 and 14 from qzs-rig bifurcation, 15 to 18 from qzs-rig poincare.',
    )
    command.add_argument(
        'numbers', nargs='*', metavar='N', help=f'of {", ".join(FIGURES)} (default: all)'
    )
    shared.out(command, 'folder for the files (default: figures)')
    shared.as_json(command)
    command.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Compute, draw, print."""
    numbers = options.numbers or list(FIGURES)
    for number in numbers:
        if number not in FIGURES:
            raise InputError(f'figure {number} is unknown; known: {", ".join(FIGURES)}')
    folder = options.out or Path('figures')
    for number in numbers:
        refuse_existing(folder / f'figure_{number}.html')
    progress = bar(len(numbers), 'figures', 'figures')
    document: dict[str, Any] = {'figures': []}
    lines = []
    try:
        for number in numbers:
            paths = [str(path) for path in FIGURES[number](folder)]
            lines += [f'figure {number}  {path}' for path in paths]
            document['figures'].append({'number': number, 'files': paths})
            progress.update(1)
    finally:
        progress.close()
    shared.show(options, document, '\n'.join(lines))
    return 0
