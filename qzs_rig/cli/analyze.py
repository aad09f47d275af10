"""`qzs-rig analyze`: the estimator over a bag."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from qzs_rig import files
from qzs_rig.cli import options as shared
from qzs_rig.compare import compare
from qzs_rig.prediction.predict import predict
from qzs_rig.report.run_page import events_table, write_report
from qzs_rig.run import runfolder
from qzs_rig.run.offline import analyze


def add_to(verbs: Any) -> None:
    """`analyze` on the command line."""
    command = verbs.add_parser(
        'analyze',
        help='estimate transmissibility from a bag',
        description='Run the analyzer over a bag: bit by bit the estimate of the live run. '
        'A bag of real sensors works too: name topics, axes and scales with '
        '--set analyzer.base.topic=/imu_a --set analyzer.base.axis.vertical=-linear_acceleration.y',
    )
    command.add_argument('bag', type=Path, metavar='BAG', help='run folder, bag folder or .mcap')
    shared.assignments(command)
    shared.out(command, 'new folder for estimate.json and report.html (default: keep nothing)')
    shared.as_json(command)
    command.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Analyze, maybe keep, print."""
    if options.out:
        files.refuse_occupied(options.out)
    analysis = analyze(options.bag, options.assignments)
    name = analysis.sheet.run_id if analysis.sheet else options.bag.name
    text = events_table([(name, analysis.estimate)]).to_text()
    if not analysis.estimate.curves:
        text += '\nno degree of freedom is excited above analyzer.floor_acceleration or floor_rate'
    if options.out:
        predictions = predict(analysis.spec) if analysis.sheet else ()
        if analysis.sheet:
            runfolder.keep_theory(options.out, name, predictions, analysis.estimate)
        path = files.write_new(options.out / 'estimate.json', analysis.estimate.to_json() + '\n')
        write_report(
            options.out / 'report.html',
            f'{options.bag.name}: transmissibility',
            [(name, analysis.estimate)],
            theory=predictions,
            facts=[('bag', str(options.bag))],
            tables=compare([(name, analysis.estimate)], predictions).tables(),
        )
        text += f'\n\nestimate {path}\nreport   {options.out / "report.html"}'
    shared.show(options, analysis.estimate.to_document(), text)
    return 0
