"""How a run ends: report, table, JSON, exit code; the same for nodes and for one process."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from qzs_rig.claims import STATIC, paper
from qzs_rig.cli.options import show
from qzs_rig.compare import compare
from qzs_rig.estimation.estimate import Estimate
from qzs_rig.parameters import RunSpec
from qzs_rig.prediction.curve import Prediction
from qzs_rig.prediction.labels import label_all
from qzs_rig.report.names import direction_name, dof_name
from qzs_rig.report.run_page import events_table, write_report


def present(
    options: argparse.Namespace,
    document: dict[str, Any],
    estimate: Estimate,
    spec: RunSpec,
    folder: Path | None,
    predictions: Sequence[Prediction],
) -> int:
    """Write `report.html`, print table or JSON; returns the exit code."""
    if folder is not None:
        document['report'] = str(folder / 'report.html')
        write_run_report(folder / 'report.html', document, estimate, spec, predictions)
    show(options, document, '\n'.join(_lines(document, estimate, predictions)))
    return exit_code(document)


def write_run_report(
    path: Path,
    document: dict[str, Any],
    estimate: Estimate,
    spec: RunSpec,
    predictions: Sequence[Prediction],
) -> None:
    """The page of one run."""
    run = (document['run_id'], estimate)
    name = document.get('scenario') or 'run'
    write_report(
        path,
        f'{name}: transmissibility',
        [run],
        theory=predictions,
        facts=_facts(document, spec),
        tables=[*compare([run], predictions).tables(), paper.table(paper.verdicts(STATIC))],
    )


def exit_code(document: dict[str, Any]) -> int:
    """0 ok, 1 aborted, 3 lossy."""
    if document.get('state') == 'aborted':
        return 1
    return 3 if any(topic['lost'] for topic in document['topics'].values()) else 0


def caution(texts: tuple[str, ...]) -> None:
    """Say what a user should know, on stderr."""
    for text in texts:
        print(f'caution: {text}', file=sys.stderr)


def _lines(
    document: dict[str, Any], estimate: Estimate, predictions: Sequence[Prediction]
) -> list[str]:
    speed = document['rig_s'] / document['wall_s'] if document['wall_s'] > 0 else 0.0
    lost = sum(topic['lost'] for topic in document['topics'].values())
    received = sum(topic['received'] for topic in document['topics'].values())
    lines = [
        events_table([(document['run_id'], estimate)]).to_text(),
        '',
        *(
            f'{dof_name(item.dof)} {direction_name(item.direction)}, {item.theory}: {item.sentence}'
            for item in label_all(estimate, predictions)
        ),
        '',
        f'{document["mode"]}: {document["rig_s"]:.1f} s of rig time in '
        f'{document["wall_s"]:.2f} s ({speed:.0f} times real time), '
        f'{received} samples received, {lost} lost',
    ]
    if document.get('state') == 'aborted':
        lines.append(f'aborted: {document.get("reason")}')
    named = [(name, document[name]) for name in ('bag', 'estimate', 'report') if document[name]]
    return lines + [f'{name:9}{path}' for name, path in named]


def _facts(document: dict[str, Any], spec: RunSpec) -> list[tuple[str, str]]:
    lost = sum(topic['lost'] for topic in document['topics'].values())
    changed = {k: v for k, v in spec.given.items() if not k.startswith(('run.', 'analyzer.'))}
    return [
        ('scenario', str(document.get('scenario', ''))),
        ('run', document['run_id']),
        ('mode', document['mode'].replace('_', ' ')),
        ('restoring law', spec.text('platform.law')),
        ('sensor', spec.text('sensor.kind')),
        ('sample rate', f'{spec.number("run.rate"):g} Hz'),
        ('rig time', f'{document["rig_s"]:.2f} s in {document["wall_s"]:.2f} s'),
        ('lost samples', str(lost)),
        ('state', f'{document.get("state", "finished")} {document.get("reason", "")}'.strip()),
        ('parameters', ', '.join(f'{k} = {v}' for k, v in changed.items())),
    ]
