"""`qzs-rig design`: a platform proposed for a payload, or warnings about an existing one."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from qzs_rig import scenario
from qzs_rig.cli import options as shared
from qzs_rig.design import tables
from qzs_rig.design.check import Case, warnings
from qzs_rig.design.proposal import Wish, propose, trial_text
from qzs_rig.errors import InputError
from qzs_rig.files import refuse_existing, write_new
from qzs_rig.report.table import Table

WISHES = ('mass', 'onset', 'stroke', 'level', 'displacement', 'zeta')


def add_to(verbs: Any) -> None:
    """`design` on the command line."""
    command = verbs.add_parser(
        'design',
        help='springs and lengths for a payload, an onset, a stroke and a level; --check warns',
        description='Propose a platform: quasi-zero stiffness (16) that does not tip (19) and '
        'carries the payload at its working point, with its vertical response by one-term theory '
        'and springs to order. With --check: warnings about the platform of a scenario.',
    )
    number = {'type': float, 'default': None}
    command.add_argument('--mass', metavar='KG', help='payload', **number)
    command.add_argument(
        '--onset', metavar='HZ', help='it shall isolate above this frequency', **number
    )
    command.add_argument(
        '--stroke', metavar='M', help='largest relative motion, to either side', **number
    )
    level = command.add_mutually_exclusive_group()
    level.add_argument(
        '--level', metavar='M/S²', help='amplitude of a constant base acceleration', **number
    )
    level.add_argument(
        '--displacement', metavar='M', help='amplitude of a constant base displacement', **number
    )
    command.add_argument('--zeta', help='damping ratio (default: 0.1)', **number)
    command.add_argument(
        '--yaml', type=Path, metavar='FILE', help='write a scenario that qzs-rig run performs'
    )
    command.add_argument(
        '--check',
        nargs='?',
        const=scenario.DEFAULT,
        metavar='SCENARIO',
        help='warn about the platform of a scenario at its vertical level '
        f'(default: {scenario.DEFAULT}, Table 1)',
    )
    shared.assignments(command)
    shared.as_json(command)
    command.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Propose or check, print; warnings do not change the exit code."""
    return _propose(options) if options.check is None else _check(options)


def _propose(options: argparse.Namespace) -> int:
    if options.assignments:
        raise InputError(
            '--set changes an existing design; add --check, or say what is wanted by --mass, '
            '--onset, --stroke and --level'
        )
    if options.yaml is not None:
        refuse_existing(options.yaml)
    proposal = propose(_wish(options))
    case = Case.proposed(proposal)
    document = tables.document(case, proposal)
    text = _text([tables.proposal_table(proposal), *tables.tables(case)], document['warnings'])
    if options.yaml is not None:
        write_new(options.yaml, trial_text(proposal).encode())
        document['yaml'] = str(options.yaml)
        text += f'\n\nwrote    {options.yaml}; try it: qzs-rig run {options.yaml}'
    shared.show(options, document, text)
    return 0


def _check(options: argparse.Namespace) -> int:
    given = [n for n in (*WISHES, 'yaml') if n != 'stroke' and getattr(options, n) is not None]
    if given:
        raise InputError(
            f'--check takes the design of a scenario; leave out --{given[0]}, or change the '
            'scenario with --set'
        )
    if options.stroke is not None and not options.stroke > 0.0:
        raise InputError(f'--stroke {options.stroke:g} must be a number above 0')
    case = Case.of_spec(scenario.load(options.check, options.assignments), options.stroke)
    said = warnings(case)
    shared.show(options, tables.document(case), _text(tables.tables(case), said))
    return 0


def _wish(options: argparse.Namespace) -> Wish:
    missing = [name for name in ('mass', 'onset', 'stroke') if getattr(options, name) is None]
    if options.level is None and options.displacement is None:
        missing.append('level (or --displacement)')
    if missing:
        raise InputError(
            f'design needs --{" and --".join(missing)}; or --check for an existing design'
        )
    held = 'acceleration' if options.displacement is None else 'displacement'
    level = options.level if options.displacement is None else options.displacement
    zeta = 0.1 if options.zeta is None else options.zeta
    return Wish(options.mass, options.onset, options.stroke, level, held, zeta)


def _text(tables: list[Table], said: dict[str, str]) -> str:
    blocks = [table.to_text() for table in tables]
    lines = [f'warning: {name}: {words}' for name, words in said.items()]
    return '\n\n'.join([*blocks, '\n'.join(lines) or 'no warnings'])
