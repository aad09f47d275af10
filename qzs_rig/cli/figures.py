"""`qzs-rig figures`: the paper's dynamic figures, drawn by the rig."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from qzs_rig.cli import options as shared
from qzs_rig.cli.progress import bar
from qzs_rig.errors import InputError
from qzs_rig.paper_figures import FIGURES, write


def add_to(verbs: Any) -> None:
    """`figures` on the command line."""
    command = verbs.add_parser(
        'figures',
        help="the paper's dynamic figures, computed and measured anew",
        description="Draw the paper's figures of motion as the rig computes and measures them: an "
        'interactive page, SVG and PNG each. Figures 9 to 12 come from qzs-rig statics.',
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
    progress = bar(len(numbers), 'figures', 'figures')
    document: dict[str, Any] = {'figures': []}
    lines = []
    try:
        for number in numbers:
            figure = FIGURES[number]()
            paths = write.measured(folder, figure)
            lines += [figure.title, f'    {figure.caption}', *(f'    {path}' for path in paths)]
            document['figures'].append(
                {'number': number, 'title': figure.title, 'files': [str(path) for path in paths]}
            )
            progress.update(1)
    finally:
        progress.close()
    shared.show(options, document, '\n'.join(lines))
    return 0
