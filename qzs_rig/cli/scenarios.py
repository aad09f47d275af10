"""`qzs-rig scenarios`: what can be run, and everything that can be set."""

from __future__ import annotations

import argparse
from typing import Any

from qzs_rig import scenario
from qzs_rig.cli import options as shared


def add_to(verbs: Any) -> None:
    """`scenarios` on the command line."""
    command = verbs.add_parser(
        'scenarios',
        help='list scenarios and parameters',
        description='The shipped scenarios, or with --parameters every parameter with default, '
        'unit and range.',
    )
    command.add_argument('--parameters', action='store_true', help='list all parameters')
    shared.as_json(command)
    command.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Print the list."""
    if options.parameters:
        rows = [
            {
                'name': p.name,
                'default': p.default,
                'unit': p.unit,
                'range': p.range_text,
                'text': p.text,
            }
            for p in scenario.parameters()
        ]
        lines = [
            f'{row["name"]} = {"unset" if row["default"] is None else row["default"]}'
            f'{" " + str(row["unit"]) if row["unit"] else ""}\n    {row["text"]} ({row["range"]})'
            for row in rows
        ]
        shared.show(options, {'parameters': rows}, '\n'.join(lines))
        return 0
    folder = scenario.config_folder()
    first = scenario.headlines()
    text = '\n'.join(f'{name:18}{line}' for name, line in first.items())
    document = {'folder': str(folder), 'scenarios': first}
    shared.show(options, document, f'{text}\n\nfiles in {folder}')
    return 0
