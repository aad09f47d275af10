"""`qzs-rig compare`: runs against each other and against theory."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

from qzs_rig.cli import options as shared
from qzs_rig.compare import compare
from qzs_rig.prediction.curve import Prediction
from qzs_rig.prediction.predict import predict
from qzs_rig.report.run_page import write_report
from qzs_rig.run.offline import Analysis, recorded


def add_to(verbs: Any) -> None:
    """`compare` on the command line."""
    command = verbs.add_parser(
        'compare',
        help='overlay runs, bags or estimates, with theory',
        description='Overlay two or more runs with their theory and tabulate the differences '
        'of curves, onset, peak and jumps. The first one is the reference.',
    )
    command.add_argument(
        'items', nargs='+', type=Path, metavar='RUN', help='run folder, bag or estimate.json'
    )
    command.add_argument('--no-theory', action='store_true', help='leave the theory out')
    command.add_argument(
        '--report', type=Path, metavar='FILE', help='page to write (default: compare_<A>_<B>.html)'
    )
    shared.as_json(command)
    command.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Compare, write the page, print."""
    runs = [(path, recorded(path)) for path in options.items]
    labels = _labels(options.items)
    estimates = [(label, run.estimate) for label, (_, run) in zip(labels, runs, strict=True)]
    theory = [] if options.no_theory else _theory(labels, [run for _, run in runs])
    result = compare(estimates, theory)
    report = options.report or Path(f'compare_{"_".join(labels)[:80]}.html')
    write_report(
        report,
        ' against '.join(labels),
        estimates,
        theory=theory,
        facts=[(label, _fact(path, run)) for label, (path, run) in zip(labels, runs, strict=True)],
        tables=result.tables(),
    )
    document = {**result.to_document(), 'report': str(report)}
    shared.show(options, document, f'{result.to_text()}\n\nreport   {report}')
    return 0


def _labels(paths: list[Path]) -> list[str]:
    names = [path.parent.name if path.name == 'estimate.json' else path.name for path in paths]
    names = [name or str(path.resolve().name) for name, path in zip(names, paths, strict=True)]
    return [
        name if names.count(name) == 1 else f'{name} ({number})'
        for number, name in enumerate(names, start=1)
    ]


def _theory(labels: list[str], runs: list[Analysis]) -> list[Prediction]:
    """Each different platform's theory once."""
    curves: list[Prediction] = []
    seen: list[Any] = []
    for label, run in zip(labels, runs, strict=True):
        if run.sheet is None:
            continue
        physics = run.spec.sections('platform', 'excitation')
        if physics not in seen:
            seen.append(physics)
            curves += [_named(curve, label, len(runs)) for curve in predict(run.spec)]
    return curves


def _named(curve: Prediction, label: str, runs: int) -> Prediction:
    return curve if runs == 1 else replace(curve, label=f'{curve.label}, {label}')


def _fact(path: Path, run: Analysis) -> str:
    if run.sheet is None:
        return str(path)
    law = run.spec.text('platform.law')
    return f'{path}: scenario {run.sheet.scenario}, law {law}, {run.sheet.mode}, {run.sheet.state}'
