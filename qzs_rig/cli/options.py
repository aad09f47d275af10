"""Options that several commands share."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tqdm import tqdm

from qzs_rig.parameters import RunSpec
from qzs_rig.scenario import DEFAULT, assigned, load, of


def bar(total: float, unit: str, text: str) -> Any:
    """A bar that shows nothing where stderr is no terminal."""
    return tqdm(
        total=total,
        unit=unit,
        desc=text,
        disable=None,
        leave=False,
        mininterval=0.1,
        bar_format='{desc} {percentage:3.0f}% |{bar}| {n:.1f}/{total:.1f} {unit} '
        '[{elapsed}<{remaining}{postfix}]',
    )


def scenario(command: argparse.ArgumentParser) -> None:
    """SCENARIO, --set, --out, --json of a run."""
    command.add_argument(
        'scenario',
        nargs='?',
        default=DEFAULT,
        metavar='SCENARIO',
        help=f'name of a shipped scenario or path of a YAML file (default: {DEFAULT})',
    )
    assignments(command)
    out(command, 'folder of the run (default: runs/<time>_<scenario>_<id>)')
    as_json(command)


def platform(command: argparse.ArgumentParser, what: str) -> None:
    """SCENARIO, which may be left out, and --set, for a command that needs no run."""
    command.add_argument(
        'scenario',
        nargs='?',
        metavar='SCENARIO',
        help=f'name of a shipped scenario or path of a YAML file, which says {what} '
        '(default: Table 1)',
    )
    assignments(command)


def spec_of(options: argparse.Namespace) -> RunSpec:
    """What SCENARIO and --set say; of Table 1 without a SCENARIO."""
    if options.scenario:
        return load(options.scenario, options.assignments)
    return of(assigned(options.assignments))


def assignments(command: argparse.ArgumentParser) -> None:
    """--set."""
    command.add_argument(
        '--set',
        dest='assignments',
        action='append',
        default=[],
        metavar='NAME=VALUE',
        help='override a parameter, for instance platform.zeta=0.07; may be repeated',
    )


def out(command: argparse.ArgumentParser, text: str) -> None:
    """--out."""
    command.add_argument('--out', type=Path, metavar='DIR', help=text)


def as_json(command: argparse.ArgumentParser) -> None:
    """--json."""
    command.add_argument(
        '--json', action='store_true', help='print one JSON document on stdout, all else on stderr'
    )


SIGNED = ('--at', '--w', '--velocity', '--range', '--omega', '--margin')
"""Options whose values may begin with a minus."""


def joined(arguments: Sequence[str]) -> list[str]:
    """`--at -0.1,0.2` as `--at=-0.1,0.2`: argparse would take the minus for an option."""
    words: list[str] = []
    for word in arguments:
        if words and words[-1] in SIGNED:
            words[-1] += f'={word}'
        else:
            words.append(word)
    return words


def show(
    options: argparse.Namespace,
    document: dict[str, Any],
    text: str,
    written: Sequence[Path] = (),
) -> None:
    """The document with --json, else the text; either names the files `written`, if any."""
    if written:
        document = document | {'files': [str(path) for path in written]}
        text += '\n\n' + '\n'.join(f'wrote    {path}' for path in written)
    print(json.dumps(document, allow_nan=False) if options.json else text)
