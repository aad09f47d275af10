"""`qzs-rig springs`: the paper's springs checked, and springs to order."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from qzs_rig import scenario
from qzs_rig.cli import options as shared
from qzs_rig.errors import InputError
from qzs_rig.mechanics import spring_selection as selection
from qzs_rig.mechanics import springs
from qzs_rig.mechanics.platform import platform_design
from qzs_rig.mechanics.spring_selection import Checked, CheckedLeaf, Wanted
from qzs_rig.report.table import Table

HELICAL = (
    *('spring', 'd mm', 'D mm', 'n', 'rate N/m', 'index', 'force N', 'stress MPa', 'allowed MPa'),
    *('free mm', 'clear mm', 'mass kg', 'remark'),
)
LEAF = ('spring', 'b mm', 'h mm', 'l mm', 'rate N/m', 'stress MPa', 'allowed MPa', 'remark')


def add_to(verbs: Any) -> None:
    """`springs` on the command line."""
    command = verbs.add_parser(
        'springs',
        help="check the paper's springs, or list springs to order",
        description='Without --rate: the springs of Table 3 under the platform of --set. With '
        '--rate: standard wire and coil combinations (or leaves) that pass stress, solid length '
        'and buckling, lightest first. Lengths in mm, as drawings have them.',
    )
    command.add_argument('--rate', type=float, metavar='N/m', help='wanted rate')
    command.add_argument(
        '--kind',
        choices=('compression', 'tension', 'leaf'),
        default='compression',
        help='of spring',
    )
    command.add_argument('--deflection', type=float, metavar='MM', help='largest deflection')
    command.add_argument(
        '--load', type=float, metavar='N', help='largest load, instead of --deflection; of a leaf'
    )
    command.add_argument('--outside', type=float, metavar='MM', help='largest outside diameter')
    command.add_argument(
        '--length',
        type=float,
        metavar='MM',
        help='largest free length; of a tension spring extended; of a leaf its length',
    )
    command.add_argument(
        '--width', type=float, metavar='MM', default=100.0, help='of a leaf, at most'
    )
    command.add_argument('--ends', default='hinged', help=f'{", ".join(springs.ENDS)} (buckling)')
    command.add_argument('--limit', type=int, default=10, metavar='N', help='rows (default: 10)')
    shared.assignments(command)
    shared.as_json(command)
    command.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Check or select, print; exit code 1 where no spring fits."""
    if options.rate is None:
        return _paper(options)
    if options.kind == 'leaf':
        return _leaves(options)
    return _helical(options)


def _paper(options: argparse.Namespace) -> int:
    spec = scenario.of(scenario.assigned(options.assignments))
    design, L20, k1 = platform_design(spec), spec.number('platform.L20'), spec.number('platform.k1')
    wide, tolerance = 1.0, 0.05
    central = Wanted(
        k1,
        design.L1 * L20,
        wide,
        design.L1 * L20 + springs.CENTRAL.solid_length,
        'tension',
        tolerance=tolerance,
    )
    suspension = Wanted(
        design.A * k1, (1.0 - design.a) * L20, wide, L20, ends=options.ends, tolerance=tolerance
    )
    helical = [
        ('central', selection.check(springs.CENTRAL, central)),
        ('suspension', selection.check(springs.SUSPENSION, suspension)),
    ]
    load = design.b * k1 * L20 / 4.0
    k3 = design.k3 * k1
    leaves = [
        ('leaf of Table 3', selection.check_leaf(springs.PAPER_LEAF, load)),
        *(
            (name, selection.check_leaf(springs.Leaf.of_stiffness(rate, 0.08, L20), load))
            for name, rate in (('leaf of rate k3', k3), ('leaf of rate k3/4 (E11)', k3 / 4.0))
        ),
    ]
    document = {
        'helical': [_helical_document(name, c) for name, c in helical],
        'leaves': [_leaf_document(name, c) for name, c in leaves],
    }
    tables = [
        _helical_table('Table 3 at the working point, SH wire', helical),
        _leaf_table(f'Leaf springs under a quarter of b, {load:.0f} N', leaves),
    ]
    shared.show(options, document, '\n\n'.join(table.to_text() for table in tables))
    return 0


def _helical(options: argparse.Namespace) -> int:
    for name in ('outside', 'length'):
        if getattr(options, name) is None:
            raise InputError(f'--rate needs --{name} in mm')
    found = selection.candidates(
        Wanted(
            options.rate,
            _deflection(options),
            1e-3 * options.outside,
            1e-3 * options.length,
            options.kind,
            selection.known_ends(options.ends),
        )
    )
    rows = [(options.kind, c) for c in found[: options.limit]]
    document = {'found': len(found), 'helical': [_helical_document(*row) for row in rows]}
    text = _helical_table(f'{len(found)} springs fit, lightest first', rows).to_text()
    shared.show(options, document, text if rows else 'no spring fits; allow more room')
    return 0 if rows else 1


def _leaves(options: argparse.Namespace) -> int:
    if options.length is None or options.load is None:
        raise InputError('--kind leaf needs --length in mm and --load in N')
    for name in ('rate', 'length', 'load', 'width'):
        if not getattr(options, name) > 0.0:
            raise InputError(f'--{name} {getattr(options, name):g} must be above 0')
    found = selection.leaves(
        options.rate, options.load, 1e-3 * options.length, 1e-3 * options.width
    )
    rows = [('leaf', c) for c in found[: options.limit]]
    document = {'found': len(found), 'leaves': [_leaf_document(*row) for row in rows]}
    text = _leaf_table('Leaves of stocked thickness, least stressed first', rows).to_text()
    shared.show(options, document, text if rows else 'no leaf fits; allow more width')
    return 0 if any(not c.failures for _, c in rows) else 1


def _deflection(options: argparse.Namespace) -> float:
    if (options.deflection is None) == (options.load is None):
        raise InputError('--rate needs either --deflection in mm or --load in N')
    if options.load is not None:
        return float(options.load / options.rate) if options.rate > 0.0 else 0.0
    return float(1e-3 * options.deflection)


def _helical_table(caption: str, rows: Sequence[tuple[str, Checked]]) -> Table:
    cells = []
    for name, c in rows:
        s = c.spring
        numbers = (
            *(f'{1e3 * s.d:g}', f'{1e3 * s.D:g}', f'{s.n:g}', f'{s.rate:.0f}', f'{s.index:.2f}'),
            *(f'{c.force:.0f}', f'{1e-6 * c.stress:.0f}', f'{1e-6 * s.allowable:.0f}'),
            *(f'{1e3 * c.free_length:.0f}', f'{1e3 * c.clearance:.0f}', f'{s.mass:.2f}'),
        )
        cells.append((name, *numbers, _remark(c.failures)))
    return Table(caption, HELICAL, tuple(cells), labels=1)


def _leaf_table(caption: str, rows: Sequence[tuple[str, CheckedLeaf]]) -> Table:
    cells = []
    for name, c in rows:
        leaf = c.leaf
        numbers = (
            *(f'{1e3 * leaf.b:.1f}', f'{1e3 * leaf.h:.2f}', f'{1e3 * leaf.length:.0f}'),
            *(f'{leaf.stiffness:.1f}', f'{1e-6 * c.stress:.0f}'),
            f'{1e-6 * selection.LEAF_ALLOWABLE:.0f}',
        )
        cells.append((name, *numbers, _remark(c.failures)))
    return Table(caption, LEAF, tuple(cells), labels=1)


def _remark(failures: tuple[str, ...]) -> str:
    return ', '.join(failures) or 'ok'


def _helical_document(name: str, c: Checked) -> dict[str, Any]:
    s = c.spring
    return {
        'spring': name,
        'kind': s.kind,
        'd': s.d,
        'D': s.D,
        'n': s.n,
        'rate': s.rate,
        'index': s.index,
        'wahl': s.wahl,
        'force': c.force,
        'stress': c.stress,
        'allowable': s.allowable,
        'free_length': c.free_length,
        'solid_length': s.solid_length,
        'clearance': c.clearance,
        'slenderness': c.slenderness,
        'buckles_at': c.buckles_at if c.buckles_at < 1e9 else None,
        'mass': s.mass,
        'failures': list(c.failures),
    }


def _leaf_document(name: str, c: CheckedLeaf) -> dict[str, Any]:
    leaf = c.leaf
    return {
        'spring': name,
        'b': leaf.b,
        'h': leaf.h,
        'length': leaf.length,
        'J': leaf.J,
        'rate': leaf.stiffness,
        'stress': c.stress,
        'allowable': selection.LEAF_ALLOWABLE,
        'failures': list(c.failures),
    }
