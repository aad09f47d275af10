"""`qzs-rig replay`: a bag's topics back on the air."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from qzs_rig import files
from qzs_rig.cli import options as shared
from qzs_rig.cli.nodes import Nodes, environment, need_ros
from qzs_rig.errors import InputError
from qzs_rig.run.offline import recorded_spec


def add_to(verbs: Any) -> None:
    """`replay` on the command line."""
    command = verbs.add_parser(
        'replay',
        help="put a bag's topics back, into a platform or an analyzer",
        description='Publish the recorded base motion (into a platform) or the recorded Imu topics '
        '(into an analyzer), with their original stamps. In lockstep the result is bit by bit that '
        'of the recorded run. The nodes named with --start are started here with the recorded '
        'parameters; others are waited for.',
    )
    command.add_argument('bag', type=Path, metavar='BAG', help='run folder, bag folder or .mcap')
    command.add_argument(
        '--topics',
        choices=('motion', 'imu'),
        default='motion',
        help='motion: base/motion into a platform (default); imu: both Imu topics into an analyzer',
    )
    command.add_argument(
        '--rate', type=float, help='real time times this factor (default: lockstep)'
    )
    command.add_argument(
        '--peers', help='nodes to wait for, comma separated (default: what --topics feeds)'
    )
    command.add_argument(
        '--start',
        nargs='*',
        default=[],
        choices=('platform', 'analyzer'),
        help='start these nodes here, too',
    )
    shared.out(command, 'folder of the run that a started analyzer keeps')
    shared.assignments(command)
    shared.as_json(command)
    command.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Start what is asked for, replay, report."""
    if options.rate is not None and not 0 < options.rate <= 1000:
        raise InputError(
            f'--rate {options.rate} is out of range; give a factor above 0, up to 1000'
        )
    if options.out:
        files.refuse_occupied(options.out)
    need_ros()
    spec = recorded_spec(options.bag, options.assignments)
    feeds = 'platform' if options.topics == 'motion' else 'analyzer'
    peers = options.peers or ','.join(dict.fromkeys([feeds, *options.start]))
    with environment() as env:
        print(f'replay in ROS_DOMAIN_ID={env["ROS_DOMAIN_ID"]}', file=sys.stderr)
        return _perform(options, Nodes(spec, env), peers)


def _perform(options: argparse.Namespace, nodes: Nodes, peers: str) -> int:
    mode = 'lockstep' if options.rate is None else 'real_time'
    stopped = False
    try:
        if 'analyzer' in options.start:
            out = {'folder': str(options.out.absolute())} if options.out else {}
            nodes.start('analyzer', **out)
        if 'platform' in options.start:
            nodes.start('platform')
        nodes.start(
            'player',
            bag=str(options.bag.absolute()),
            topics=options.topics,
            mode=mode,
            rate=options.rate or 1.0,
            peers=peers,
            scenario='replay',
        )
        while nodes.running():
            nodes.progress(timeout=0.1)
            if any(nodes.codes().values()) and not nodes.wait(5.0):
                break
    except KeyboardInterrupt:
        print('stopping the nodes', file=sys.stderr)
        stopped = True
    finally:
        nodes.stop()
        errors, codes = nodes.errors(), nodes.codes()
        nodes.close()
    for line in errors:
        print(line, file=sys.stderr)
    lossy = bool(options.out) and _lost(options.out)
    code = (
        3
        if lossy and not any(codes.values())
        else max(
            (1 if c not in (0, 2, 3) else c for c in codes.values() if c is not None), default=1
        )
    )
    if stopped:
        code = 1
    document: dict[str, Any] = {
        'bag': str(options.bag),
        'topics': options.topics,
        'mode': mode,
        'codes': codes,
    }
    document['out'] = str(options.out) if options.out else None
    if options.json:
        print(json.dumps(document))
    elif code == 0:
        print(f'replayed {options.topics} of {options.bag}')
    return code


def _lost(folder: Path) -> int:
    """Samples that the started analyzer missed; 0 where it kept nothing."""
    path = folder / 'run.json'
    if not path.is_file():
        return 0
    topics = json.loads(path.read_text(encoding='utf-8'))['topics']
    return sum(int(topic['lost']) for topic in topics.values())
