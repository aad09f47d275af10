"""Options of the commands that follow one degree of freedom under a harmonic base."""

from __future__ import annotations

import argparse
import math
from dataclasses import replace

from qzs_rig import scenario
from qzs_rig.cli import options as shared
from qzs_rig.errors import InputError
from qzs_rig.mechanics.platform import Platform
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.parameters import RunSpec
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import DOFS, TRANSLATIONS

HELD = ('displacement', 'velocity', 'acceleration')
PAPER_AMPLITUDE = 0.6
"""Base amplitude over L20 in Figures 13 to 18."""
PAPER_ROTATION = math.radians(5.0)
"""The same for rotations, in rad."""
PAPER_FREQUENCY = 6.28
"""Excitation frequency of Figures 13 to 18 in rad/s."""


def motion(command: argparse.ArgumentParser, dof: str | None, amplitude: str) -> None:
    """--law, --dof, --zeta, --amplitude, --held; defaults as told."""
    command.add_argument(
        '--law', help=f'restoring law: {", ".join(RESTORING)} (default: platform.law)'
    )
    command.add_argument(
        '--dof',
        default=dof,
        help=f'degree of freedom: {", ".join(DOFS)} (default: {dof or "all four"})',
    )
    command.add_argument(
        '--zeta', type=float, metavar='Z', help="damping ratio (default: the platform's)"
    )
    command.add_argument(
        '--amplitude',
        type=float,
        metavar='H',
        help=f'base amplitude over L20, or in rad (default: {amplitude}, or 5 degrees)',
    )
    command.add_argument(
        '--held',
        default=HELD[0],
        choices=HELD,
        help='quantity of the base whose amplitude is the same at all frequencies; --amplitude is '
        'the one at Omega = 1 (default: displacement)',
    )


def add(command: argparse.ArgumentParser, files: str, dof: str | None = DOFS[0]) -> None:
    """`motion` with one frequency: --omega, --frequency; --set, --out, --json."""
    motion(command, dof, '0.6 as in the paper')
    command.add_argument(
        '--frequency',
        type=float,
        metavar='RAD/S',
        help=f'excitation frequency in rad/s (default: {PAPER_FREQUENCY} as in the paper)',
    )
    command.add_argument(
        '--omega',
        type=float,
        metavar='O',
        help='excitation frequency over omega0 of the degree of freedom, instead of --frequency',
    )
    shared.assignments(command)
    shared.out(command, files)
    shared.as_json(command)


def spec_of(options: argparse.Namespace) -> RunSpec:
    """The platform that --set and --law describe."""
    spec = scenario.of(scenario.assigned(options.assignments))
    if options.law is None:
        return spec
    if options.law not in RESTORING:
        raise InputError(f'unknown law {options.law!r}; known: {", ".join(RESTORING)}')
    return spec.override({'platform.law': options.law})


def dofs_of(options: argparse.Namespace) -> tuple[str, ...]:
    """The degree of freedom asked for, or all."""
    if options.dof is None:
        return DOFS
    if options.dof not in DOFS:
        raise InputError(f'unknown degree of freedom {options.dof!r}; known: {", ".join(DOFS)}')
    return (options.dof,)


def oscillator_of(options: argparse.Namespace, spec: RunSpec, dof: str) -> Oscillator:
    """The oscillator of `dof` with --zeta and --amplitude."""
    amplitude = options.amplitude
    if amplitude is None:
        amplitude = PAPER_AMPLITUDE if dof in TRANSLATIONS else PAPER_ROTATION
    found = Oscillator.of(spec, dof, amplitude, HELD.index(options.held))
    return found if options.zeta is None else replace(found, zeta=options.zeta)


def omega_of(options: argparse.Namespace, spec: RunSpec, dof: str) -> float:
    """Ω by --omega, or by --frequency over omega0 of `dof`."""
    if options.omega is not None and options.frequency is not None:
        raise InputError('--omega and --frequency say the same thing twice; keep one of them')
    if options.omega is not None:
        omega = float(options.omega)
    else:
        given = PAPER_FREQUENCY if options.frequency is None else options.frequency
        omega = given / Platform.from_spec(spec).omega0[DOFS.index(dof)]
    if not (omega > 0.0 and math.isfinite(omega)):
        raise InputError(f'frequency {omega:g}; give a number above 0')
    return omega


def pair(text: str, option: str) -> tuple[float, float]:
    """LO:HI, the first below the second."""
    try:
        low, high = (float(word) for word in text.split(':'))
    except ValueError:
        raise InputError(f'{option} {text!r}: write LO:HI, for instance 0.1:1') from None
    if not (low < high and math.isfinite(high - low)):
        raise InputError(f'{option} {text!r}: the first must be below the second')
    return low, high


def at_least(value: int, least: int, option: str) -> int:
    """A count; raises InputError below `least`."""
    if value < least:
        raise InputError(f'{option} {value}: give {least} or more')
    return value
