"""`qzs-rig identify`: the platform's parameters from measured curves, and advice on its payload."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from qzs_rig import files, scenario
from qzs_rig.cli import options as shared
from qzs_rig.cli.options import bar
from qzs_rig.errors import InputError
from qzs_rig.identification import jumps
from qzs_rig.identification.fit_report import (
    fit_document,
    fit_sheet,
    fit_text,
    jumps_document,
    jumps_text,
)
from qzs_rig.identification.identify import Identified, identify
from qzs_rig.identification.points import CSV_HELP, Points, by_dof, measured, read_csv
from qzs_rig.identification.unknowns import DEFAULT
from qzs_rig.parameters import RunSpec
from qzs_rig.report.write import pictures
from qzs_rig.run import offline

EPILOG = f"""\
examples:
  qzs-rig identify runs/A                        damping, A = k2/k1 and payload trim of a run
  qzs-rig identify runs/A --fit platform.zeta,platform.A,platform.k3_hat --out fitted
  qzs-rig identify curve.csv --scenario vertical_sweep --set excitation.amplitude.vertical=3.5
  qzs-rig identify --paper                       what the paper's four frequencies fix

{CSV_HELP}.

A point lies on the branch whose stable motion is nearest to it. Left out are points that no branch
meets within a factor of two, points within 0.3 % of a fold, and of a sweep the transition at a jump
with the ringing after it; the lag of a sweep is taken off to first order in its rate. Intervals
hold with 95 % for all parameters together: Student's t on the larger of the usual and the
heteroscedasticity-robust error, out to the profile where the fit is not straight, over all
solutions that fit alike. What the points do not determine is said, with the combinations that they
do.
"""


def add_to(verbs: Any) -> None:
    """`identify` on the command line."""
    command = verbs.add_parser(
        'identify',
        help='fit damping, stiffness and payload trim to measured curves, with intervals',
        description='Fit parameters of the platform to measured transmissibility, both branches '
        'and both directions together, and say what to add to or remove from the payload.',
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.add_argument(
        'source',
        nargs='?',
        type=Path,
        metavar='BAG|CSV',
        help='run folder, bag, estimate.json, or a CSV of curves',
    )
    command.add_argument(
        '--fit',
        metavar='NAMES',
        help=f'parameters to fit, comma separated (default: {",".join(DEFAULT)})',
    )
    command.add_argument('--dof', help='fit this degree of freedom alone')
    command.add_argument(
        '--scenario',
        metavar='NAME',
        help='scenario that a CSV was measured under: how the base moved, where the fit starts',
    )
    command.add_argument(
        '--paper', action='store_true', help="the paper's four jump frequencies instead of curves"
    )
    shared.assignments(command)
    shared.out(command, 'new folder for fitted.yaml, figure and JSON')
    shared.as_json(command)
    command.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Read, fit, print."""
    if options.paper:
        return _paper(options)
    if options.source is None:
        raise InputError('nothing to identify; give a run folder, a bag or a CSV, or --paper')
    if options.out is not None:
        files.refuse_occupied(options.out)
    spec, parts = _measured(options)
    names = tuple(options.fit.split(',')) if options.fit else DEFAULT
    with bar(1.0, 'of the fit', 'fitting') as progress:
        found = identify(spec, by_dof(parts, options.dof), names)
        progress.update(1.0)
    document = fit_document(found)
    text = fit_text(found)
    written = _written(options.out, found, document) if options.out is not None else []
    for caution in found.cautions:
        print(f'caution: {caution}', file=sys.stderr)
    shared.show(options, document, text, written)
    return 0


def _measured(options: argparse.Namespace) -> tuple[RunSpec, list[Points]]:
    """The run that was measured, with --set on top for the start, and its points."""
    words = scenario.assigned(options.assignments)
    if options.source.suffix.lower() == '.csv':
        spec = scenario.load(options.scenario) if options.scenario else scenario.of({})
        return spec.override(words), read_csv(options.source)
    if options.scenario:
        raise InputError('--scenario is for a CSV; a bag knows its own, change it by --set')
    analysis = offline.recorded(options.source)
    spec = analysis.spec.override(words)
    return spec, measured(analysis.estimate, spec)


def _written(folder: Path, found: Identified, document: dict[str, Any]) -> list[Path]:
    paths = [
        files.write_new(folder / 'fitted.yaml', found.spec.to_yaml()),
        files.write_new_json(folder / 'identification.json', document),
    ]
    return paths + pictures(folder, [fit_sheet(found)])


def _paper(options: argparse.Namespace) -> int:
    if options.source is not None or options.dof or options.out is not None:
        raise InputError(
            '--paper takes no measurement, --dof or --out, only --fit and --set; leave them out'
        )
    names = tuple(options.fit.split(',')) if options.fit else jumps.PAPER_UNKNOWNS
    spec = jumps.paper_spec(scenario.assigned(options.assignments))
    found = jumps.fixed_by(spec, jumps.PAPER, names)
    shared.show(options, jumps_document(found), jumps_text(found))
    return 0
