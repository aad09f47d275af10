"""`qzs-rig modes`: where the coupled platform rests, and how it swings there."""

from __future__ import annotations

import argparse
from typing import Any

from qzs_rig.cli import options as shared
from qzs_rig.mechanics.equilibrium import Modes, modes
from qzs_rig.mechanics.geometry import SIX, Geometry
from qzs_rig.mechanics.restoring.geometric import GEOMETRIC
from qzs_rig.samples import Array

SHORT = ('z', 'x', 'yaw', 'pitch', 'y', 'roll')
"""SIX in table heads."""


def add_to(verbs: Any) -> None:
    """`modes` on the command line."""
    command = verbs.add_parser(
        'modes',
        help='equilibrium, 6x6 stiffness and modes of the coupled platform',
        description='The geometric platform with six coupled degrees of freedom: where the '
        'payload rests, stiffness and mass there, natural frequencies, shapes, coupling. '
        'platform.law is ignored; a platform that falls over is a finding (exit code 1).',
    )
    shared.platform(command, 'the platform')
    shared.as_json(command)
    command.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Solve and print."""
    geometry = Geometry.from_spec(
        shared.spec_of(options).override({'platform.law': GEOMETRIC.name})
    )
    found = modes(geometry)
    shared.show(options, to_document(geometry, found), to_text(geometry, found))
    return 0 if found.stable else 1


def to_document(geometry: Geometry, found: Modes) -> dict[str, Any]:
    """JSON-ready, SI; matrices and shapes in the order of `dofs`."""
    swinging = zip(found.frequencies_hz, found.growth, found.shapes.T, found.shares.T, strict=True)
    return {
        'schema': 'qzs_rig/modes/1',
        'dofs': list(SIX),
        'stable': found.stable,
        'hinge': geometry.hinge,
        'equilibrium': dict(zip(SIX, found.rest.pose.tolist(), strict=True)),
        'residual': found.rest.residual,
        'stiffness': found.stiffness.tolist(),
        'mass': found.mass.tolist(),
        'modes': [
            {
                'frequency_hz': frequency,
                'growth': growth,
                'shape': shape.tolist(),
                'energy_share': share.tolist(),
            }
            for frequency, growth, shape, share in swinging
        ],
        'coupling': [pair._asdict() for pair in found.couplings],
    }


def to_text(geometry: Geometry, found: Modes) -> str:
    """The tables that a user reads."""
    pose = found.rest.pose
    metres = ', '.join(f'{SHORT[n]} {1e3 * pose[n]:.3f} mm' for n in (0, 1, 4))
    radians = ', '.join(f'{SHORT[n]} {pose[n]:.4f} rad' for n in (2, 3, 5))
    lines = [
        f'equilibrium from the working point: {metres}, {radians}',
        f'hinges {geometry.hinge:.4g} N m/rad, {"stable" if found.stable else "FALLS OVER"}',
        '',
        'stiffness (N/m, N, N m)',
        *_matrix(found.stiffness),
        '',
        'mass (kg, kg m, kg m²)',
        *_matrix(found.mass),
        '',
        'modes: share of the kinetic energy',
        f'{"":14}' + ''.join(f'{name:>12}' for name in SHORT),
    ]
    for frequency, growth, share in zip(
        found.frequencies_hz, found.growth, found.shares.T, strict=True
    ):
        name = f'{growth:.4g} 1/s grows' if frequency is None else f'{frequency:.4f} Hz'
        lines.append(f'{name:>14}' + ''.join(f'{part:12.4f}' for part in share))
    lines += ['', 'coupling                                       stiffness        mass']
    lines += [
        f'  {pair.first + " - " + pair.second:42}{pair.stiffness:12.4g}{pair.mass:12.4g}'
        for pair in found.couplings
    ]
    return '\n'.join(lines if found.couplings else [*lines, '  none'])


def _matrix(matrix: Array) -> list[str]:
    size = abs(matrix).max()
    rows = [f'{"":14}' + ''.join(f'{name:>12}' for name in SHORT)]
    for name, row in zip(SHORT, matrix.tolist(), strict=True):
        # rounding of cancelled terms is none
        cells = ''.join(f'{value if abs(value) > 1e-12 * size else 0.0:12.5g}' for value in row)
        rows.append(f'{name:>14}{cells}')
    return rows
