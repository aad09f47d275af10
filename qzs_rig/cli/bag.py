"""`qzs-rig bag`: what is in a bag, and how to get back one that was cut off."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from qzs_rig.bag import info, recover
from qzs_rig.cli import options as shared


def add_to(verbs: Any) -> None:
    """`bag info` and `bag recover` on the command line."""
    group = verbs.add_parser('bag', help='describe or recover a bag')
    commands = group.add_subparsers(title='commands', metavar='COMMAND', required=True)
    describe = commands.add_parser(
        'info', help='topics, counts, lost samples', description='What is in a bag.'
    )
    _bag(describe)
    shared.as_json(describe)
    describe.set_defaults(execute=_info)
    salvage = commands.add_parser(
        'recover',
        help='salvage a bag that was not closed',
        description='Copy every complete message of a damaged or unclosed bag into a new one. '
        'The original is not touched.',
    )
    _bag(salvage)
    shared.out(salvage, 'folder of the new bag (default: <BAG>_recovered)')
    shared.as_json(salvage)
    salvage.set_defaults(execute=_recover)


def _bag(command: argparse.ArgumentParser) -> None:
    command.add_argument('bag', type=Path, metavar='BAG', help='run folder, bag folder or .mcap')


def _info(options: argparse.Namespace) -> int:
    description = info(options.bag)
    shared.show(options, description.to_document(), description.text)
    return 0 if description.lossless else 3


def _recover(options: argparse.Namespace) -> int:
    bag = options.bag.resolve()
    out = options.out or bag.parent / f'{bag.stem}_recovered'
    report = recover(options.bag, out)
    shared.show(options, report.to_document(), report.text)
    return 0
