"""`qzs-rig frf`: the theoretical frequency response, every branch of it."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable
from typing import Any

from qzs_rig.cli import options as shared
from qzs_rig.cli import oscillating
from qzs_rig.cli.options import bar
from qzs_rig.errors import InputError
from qzs_rig.mechanics.platform import coupled
from qzs_rig.report import resonance, response_page
from qzs_rig.theory.balance.coupled_response import response_of
from qzs_rig.theory.balance.harmonic_balance import VARIED
from qzs_rig.theory.balance.single_term_response import single_term_response
from qzs_rig.theory.balance.variation import varied_response
from qzs_rig.units import DOFS

TABLE_1_AMPLITUDE = 0.1
"""H in m."""

EPILOG = """\
examples:
  qzs-rig frf                                       Table 1, vertical, 0.1 m
  qzs-rig frf vertical_sweep                        what qzs-rig run vertical_sweep measures
  qzs-rig frf --law taylor --zeta 0.07 --amplitude 0.6 --omega 0.02:3 --out frf
  qzs-rig frf --law symmetric --single-term         the paper's Eq (29)
  qzs-rig frf --jump-map amplitude --omega 0.1:2    folds over the base amplitude
  qzs-rig frf --vary amplitude=0.02:0.5 --at 0.8    motions at one frequency over it
Everything is nondimensional: omega over sqrt(k1/m), motion over L20 or in rad.
"""


def add_to(verbs: Any) -> None:
    """`frf` on the command line."""
    command = verbs.add_parser(
        'frf',
        help='theory: all branches of the frequency response, stability, folds',
        description='Steady response of one degree of freedom by harmonic balance and '
        'continuation: every branch with its stability, folds and other events, isolated '
        'branches, isolation onset.',
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    oscillating.motion(command, DOFS[0], '0.1 m as in Table 1')
    command.add_argument(
        '--omega',
        metavar='LO:HI',
        help='frequency range (default: the band of SCENARIO, else 0.02:3)',
    )
    command.add_argument(
        '--harmonics', type=int, metavar='N', help='keep to N (default: as many as it takes)'
    )
    command.add_argument(
        '--no-isolas', action='store_true', help='do not look for isolated branches'
    )
    command.add_argument(
        '--single-term',
        action='store_true',
        help="the paper's Eq (29) for the cubic part of the law instead",
    )
    command.add_argument(
        '--backbone',
        action='store_true',
        help='free motions of the undamped platform too, and the damped phase resonance',
    )
    command.add_argument(
        '--jump-map',
        choices=('amplitude', 'zeta'),
        help='curves of folds while this varies from a tenth to three times its value too',
    )
    command.add_argument(
        '--vary',
        metavar='NAME=LO:HI',
        help=f'all motions at --at OMEGA while one of {", ".join(VARIED)} varies too',
    )
    command.add_argument('--at', type=float, metavar='OMEGA', help='the frequency of --vary')
    shared.out(command, 'folder for figures, page and CSV')
    shared.as_json(command)
    command.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Solve, draw, print."""
    spec, (oscillator,) = oscillating.asked(
        options, metres=TABLE_1_AMPLITUDE, single=options.single_term
    )
    band = oscillating.band_of(options, spec, oscillator) if options.omega is None else None
    low, high = band or omega_range(options.omega or '0.02:3')
    if options.harmonics is not None and not 1 <= options.harmonics <= 512:
        raise InputError(f'--harmonics {options.harmonics}: give 1 to 512, or leave it out')
    if options.single_term and options.harmonics is not None:
        raise InputError('--single-term has one harmonic; leave out --harmonics')
    if options.single_term:
        if oscillator.load:
            raise InputError(
                f'the single-term balance knows no load ({oscillator.load:.4g}); leave out '
                'platform.payload_trim, or --single-term'
            )
        answer = response_page.all_branches(
            single_term_response(oscillator, low, high), 'single term, Eq (29)'
        )
    else:
        with bar(1.0, 'of the search', 'frequency response') as progress:
            answer = response_page.all_branches(
                response_of(
                    spec,
                    oscillator,
                    low,
                    high,
                    harmonics=options.harmonics,
                    isolas=not options.no_isolas,
                    progress=_teller(progress),
                )
            )
    six = coupled(spec) and not options.single_term
    answer.document['degrees_of_freedom'] = 6 if six else 1
    if six and (options.backbone or options.jump_map or options.vary):
        answer.cautions.append(
            f'--backbone, --jump-map and --vary take {oscillator.dof} by itself, not all six '
            'degrees of freedom'
        )
    if options.backbone:
        answer = resonance.with_backbone(answer, oscillator, low, high)
    if options.jump_map:
        with bar(1.0, 'of the map', 'jump map') as progress:
            answer = resonance.with_jump_map(
                answer, oscillator, options.jump_map, (low, high), _teller(progress)
            )
    if options.vary is not None:
        varied = varied_response(oscillator, *variation(options.vary, options.at))
        answer = resonance.with_variation(answer, varied)
    text = answer.text
    written = response_page.write(options.out, answer) if options.out is not None else []
    for caution in answer.cautions:
        print(f'caution: {caution}', file=sys.stderr)
    shared.show(options, answer.document, text, written)
    return 0


def _teller(progress: Any) -> Callable[[float, str], None]:
    def tell(share: float, text: str) -> None:
        progress.set_description(text)
        progress.update(share - progress.n)

    return tell


def omega_range(text: str) -> tuple[float, float]:
    """LO:HI."""
    low, high = oscillating.pair(text, '--omega')
    if not low > 0.0:
        raise InputError(f'--omega {text!r}: the range must rise from above 0')
    return low, high


def variation(text: str, omega: float | None) -> tuple[float, str, float, float]:
    """Frequency, parameter and range of --vary NAME=LO:HI --at OMEGA."""
    if omega is None or not 0.0 < omega < math.inf:
        raise InputError(f'--vary {text!r}: give one frequency above 0 with --at, such as --at 0.8')
    name, _, span = text.partition('=')
    return omega, name, *oscillating.pair(span, f'--vary {name}')
