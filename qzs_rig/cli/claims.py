"""`qzs-rig claims`: what the paper says, and what its own equations say."""

from __future__ import annotations

import argparse
import json
import textwrap
from collections.abc import Mapping
from typing import Any

from qzs_rig.claims import CLAIMS
from qzs_rig.claims.paper import Verdict, document, verdicts
from qzs_rig.cli import options as shared
from qzs_rig.cli.options import bar
from qzs_rig.errors import InputError

WIDTH = 100


def add_to(verbs: Any) -> None:
    """`claims` on the command line."""
    command = verbs.add_parser(
        'claims',
        help="the paper's claims checked: reproduced, or not reproduced",
        description="Check the paper's claims one by one, with its own Table 1 and Table 3: "
        'C1 to C6 at rest, C7 to C14 by integration, continuation and runs of the rig.',
    )
    command.add_argument(
        'names', nargs='*', metavar='CLAIM', help='for instance C7 C13 (default: all)'
    )
    shared.as_json(command)
    command.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Check, print; a claim that fails is a result, not an error."""
    names = options.names or list(CLAIMS)
    for name in names:
        if name not in CLAIMS:
            raise InputError(f'claim {name!r} is unknown; known: {", ".join(CLAIMS)}')
    progress = bar(len(names), 'claims', 'claims')
    try:
        found = verdicts({n: CLAIMS[n] for n in names}, lambda _: progress.update(1))
    finally:
        progress.close()
    print(json.dumps(document(found), allow_nan=False) if options.json else _text(found))
    return 0


def _text(found: Mapping[str, Verdict]) -> str:
    """A heading a claim, then what it says, what was found and how, wrapped."""
    lines = []
    for name, verdict in found.items():
        lines.append(f'{name}  {verdict.text}')
        for label, words in (
            ('claim', verdict.claim),
            ('found', verdict.numbers),
            ('how', verdict.how),
        ):
            indent = f'    {label:7}'
            lines += textwrap.wrap(
                words, WIDTH, initial_indent=indent, subsequent_indent=' ' * len(indent)
            )
    return '\n'.join(lines)
