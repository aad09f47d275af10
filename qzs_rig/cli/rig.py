"""`qzs-rig rig`: three real nodes, real topics, one bag, one curve."""

from __future__ import annotations

import argparse
import json
import sys
import uuid
from pathlib import Path
from typing import Any

from qzs_rig import files, scenario
from qzs_rig.cli import options as shared
from qzs_rig.cli.nodes import Nodes, environment, need_ros
from qzs_rig.cli.options import bar
from qzs_rig.cli.outcome import caution, present
from qzs_rig.errors import InputError, RunAbortedError
from qzs_rig.estimation.estimate import from_json
from qzs_rig.estimation.settings import TrackedSineSettings
from qzs_rig.parameters import RunSpec
from qzs_rig.prediction.predict import predict
from qzs_rig.run import runfolder
from qzs_rig.run.stages import ExciterStage, PlatformStage


def add_to(verbs: Any) -> None:
    """`rig` on the command line."""
    command = verbs.add_parser(
        'rig',
        help='perform a scenario with real ROS 2 nodes and record it',
        description='Start exciter, platform and analyzer as processes of their own, perform the '
        'scenario over topics, record a bag, print onset, peak and jumps, write report.html. '
        'ROS_DOMAIN_ID is respected; without one the run takes a domain of its own.',
    )
    shared.scenario(command)
    command.add_argument('--real-time', action='store_true', help='by the clock (run.mode)')
    command.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Perform, watch, present."""
    extra = ['run.mode=real_time'] if options.real_time else []
    spec = scenario.load(options.scenario, [*options.assignments, *extra])
    refuse_bad(spec)
    need_ros()
    run_id = uuid.uuid4().hex[:8]
    folder = options.out or runfolder.new_folder(Path(options.scenario).stem, run_id)
    folder = folder.absolute()
    files.refuse_occupied(folder)
    with environment() as env:
        print(f'nodes in ROS_DOMAIN_ID={env["ROS_DOMAIN_ID"]}', file=sys.stderr)
        return _perform(options, Nodes(spec, env), spec, folder, run_id)


def _perform(
    options: argparse.Namespace, nodes: Nodes, spec: RunSpec, folder: Path, run_id: str
) -> int:
    name = Path(options.scenario).stem
    try:
        nodes.start('analyzer', folder=str(folder), progress=True)
        nodes.start('platform')
        nodes.start('exciter', run_id=run_id, scenario=name)
        try:
            _watch(nodes)
        except KeyboardInterrupt:
            print('stopping the nodes', file=sys.stderr)
            nodes.stop()
            if not folder.exists():
                raise RunAbortedError('stopped before the first sample; nothing was kept') from None
        return _finish(options, nodes, spec, folder)
    finally:
        nodes.close()


def refuse_bad(spec: RunSpec) -> None:
    """Raises what the nodes would raise, before any process starts."""
    step_ns = scenario.step_ns_of(spec)
    TrackedSineSettings.from_spec(spec)
    if spec.text('analyzer.source') != 'rig':
        raise InputError('analyzer.source must be rig here; run the analyzer node alone instead')
    ExciterStage(spec, step_ns)
    PlatformStage(spec, step_ns, awaited=0)


def _watch(nodes: Nodes) -> None:
    progress = None
    said = ''
    while nodes.running():
        line = nodes.progress(timeout=0.1)
        if line and line['state'] in ('idle', 'waiting') and line['message'] != said:
            said = line['message']
            print(said, file=sys.stderr)
        if line and line.get('of'):
            progress = progress or bar(line['of'], 'samples', 'rig')
            progress.update(line['done'] - progress.n)
            hz = [f'{value:.2f} Hz' for key, value in line.items() if key.endswith('_hz')]
            progress.set_postfix_str(', '.join(hz))
        codes = nodes.codes()
        if any(codes.values()) and not nodes.wait(5.0):
            break  # one failed and the others did not follow
    if progress:
        progress.close()


def _finish(options: argparse.Namespace, nodes: Nodes, spec: RunSpec, folder: Path) -> int:
    nodes.stop()
    caution(tuple(nodes.cautions()))
    path = folder / 'run.json'
    if folder.is_dir():
        nodes.keep_logs(folder)
    if not path.is_file():
        raise nodes.died(folder)
    for line in nodes.errors():
        print(line, file=sys.stderr)
    document = json.loads(path.read_text(encoding='utf-8'))
    document['cpu_s'] = round(nodes.cpu_s(), 3)
    estimate = from_json((folder / 'estimate.json').read_text(encoding='utf-8'))
    predictions = runfolder.theory_in(folder) or predict(spec)
    code = present(options, document, estimate, spec, folder, predictions)
    _complete(path, document)
    return code


def _complete(path: Path, document: dict[str, Any]) -> None:
    """Put what only this process knows into the run's own run.json."""
    files.rewrite(path, json.dumps(document, indent=1) + '\n')
