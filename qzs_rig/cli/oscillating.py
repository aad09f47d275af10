"""What is asked of one degree of freedom under a harmonic base: by a SCENARIO, by options."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from dataclasses import replace

from qzs_rig.cli import options as shared
from qzs_rig.errors import InputError
from qzs_rig.mechanics.platform import coupled, refuse_coupled_words
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.parameters import RunSpec
from qzs_rig.prediction.predict import range_hz
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import DOFS, QUANTITIES, TRANSLATIONS

PAPER_AMPLITUDE = 0.6
"""Base amplitude over L20 in Figures 13 to 18."""
PAPER_ROTATION = math.radians(5.0)
"""The same for rotations, in rad."""
PAPER_FREQUENCY = 6.28
"""Excitation frequency of Figures 13 to 18 in rad/s."""


def law(command: argparse.ArgumentParser) -> None:
    """--law."""
    command.add_argument(
        '--law', help=f'restoring law: {", ".join(RESTORING)} (default: platform.law)'
    )


def motion(command: argparse.ArgumentParser, dof: str, amplitude: str) -> None:
    """SCENARIO, --set, --law, --dof, --zeta, --amplitude, --held; defaults as told."""
    shared.platform(command, 'platform and base motion')
    law(command)
    command.add_argument(
        '--dof',
        help=f'degree of freedom: {", ".join(DOFS)} (default: what SCENARIO drives, else {dof})',
    )
    command.add_argument(
        '--zeta', type=float, metavar='Z', help="damping ratio (default: the platform's)"
    )
    command.add_argument(
        '--amplitude',
        type=float,
        metavar='H',
        help='base amplitude over L20, or in rad (default: excitation.amplitude of SCENARIO, else '
        f'{amplitude}, or 5 degrees)',
    )
    command.add_argument(
        '--held',
        choices=QUANTITIES,
        help='quantity of the base whose amplitude is the same at all frequencies; --amplitude is '
        'the one at Omega = 1 (default: excitation.quantity of SCENARIO, else displacement)',
    )


def add(command: argparse.ArgumentParser, files: str, dof: str = DOFS[0]) -> None:
    """`motion` with one frequency: --omega, --frequency; --out, --json."""
    motion(command, dof, '0.6 as in the paper')
    command.add_argument(
        '--frequency',
        type=float,
        metavar='RAD/S',
        help='excitation frequency in rad/s (default: excitation.frequency of a SCENARIO that '
        f'dwells, else {PAPER_FREQUENCY} as in the paper)',
    )
    command.add_argument(
        '--omega',
        type=float,
        metavar='O',
        help='excitation frequency over omega0 of the degree of freedom, instead of --frequency',
    )
    shared.out(command, files)
    shared.as_json(command)


def spec_of(options: argparse.Namespace) -> RunSpec:
    """What SCENARIO and --set say, with --law."""
    spec = shared.spec_of(options)
    if options.law is None:
        return spec
    if options.law not in RESTORING:
        raise InputError(f'unknown law {options.law!r}; known: {", ".join(RESTORING)}')
    return spec.override({'platform.law': options.law})


def asked(
    options: argparse.Namespace,
    dofs: Sequence[str] = DOFS[:1],
    metres: float | None = None,
    single: bool = True,
) -> tuple[RunSpec, list[Oscillator]]:
    """The platform asked for, and the oscillator of each motion asked for.

    Without a SCENARIO those of `dofs` under a base amplitude of `metres`, or as in the paper. With
    one they are what it drives, as it drives them; options override it. What a scenario asks
    beyond a `single` degree of freedom is refused, or said on standard error.
    """
    spec = spec_of(options)
    if options.zeta is not None:
        spec = spec.override({'platform.zeta': options.zeta})
    if single and coupled(spec):
        refuse_coupled_words(spec)
    found = [_oscillator(options, spec, dof, metres) for dof in _dofs(options, spec, dofs)]
    if coupled(spec):
        left = set(_driven(spec)) - {own.dof for own in found} if _scenario(options, spec) else ()
        if single:
            _caution('law geometric couples six degrees of freedom; each is taken by itself here, '
                     'by frf and modes all six together')  # fmt: skip
        elif left:
            _caution(f'the base moves in {", ".join(sorted(left))} too, which is left out')
    return spec, found


def _caution(text: str) -> None:
    print(f'caution: {text}', file=sys.stderr)


def _scenario(options: argparse.Namespace, spec: RunSpec) -> bool:
    """Whether the base motion is that of a run: SCENARIO or --set speaks of it."""
    return bool(options.scenario) or any(name.startswith('excitation.') for name in spec.given)


def _driven(spec: RunSpec) -> tuple[str, ...]:
    return tuple(dof for dof in DOFS if spec.number(f'excitation.amplitude.{dof}'))


def _dofs(options: argparse.Namespace, spec: RunSpec, dofs: Sequence[str]) -> Sequence[str]:
    if options.dof is not None:
        if options.dof not in DOFS:
            raise InputError(f'unknown degree of freedom {options.dof!r}; known: {", ".join(DOFS)}')
        return (options.dof,)
    driven = _driven(spec) if _scenario(options, spec) else ()
    if len(driven) > 1 and len(dofs) == 1:
        raise InputError(f'the scenario drives {" and ".join(driven)}; take one of them by --dof')
    return driven or dofs


def _oscillator(
    options: argparse.Namespace, spec: RunSpec, dof: str, metres: float | None
) -> Oscillator:
    scenario = _scenario(options, spec)
    if scenario and options.amplitude is None:
        own = Oscillator.driven(spec, dof)
        return replace(own, falloff=QUANTITIES.index(options.held)) if options.held else own
    held = options.held or (spec.text('excitation.quantity') if scenario else QUANTITIES[0])
    own = Oscillator.of(spec, dof, 0.0, QUANTITIES.index(held))
    if options.amplitude is not None:
        return replace(own, amplitude=options.amplitude)
    if dof not in TRANSLATIONS:
        return replace(own, amplitude=PAPER_ROTATION)
    return replace(own, amplitude=PAPER_AMPLITUDE if metres is None else metres / own.length)


def omega_of(options: argparse.Namespace, spec: RunSpec, own: Oscillator) -> float:
    """Ω by --omega or --frequency, of a scenario that dwells, or of the paper."""
    if options.omega is not None and options.frequency is not None:
        raise InputError('--omega and --frequency say the same thing twice; keep one of them')
    if options.omega is not None:
        omega = float(options.omega)
    elif options.frequency is None and _scenario(options, spec):
        if spec.text('excitation.kind') != 'sine':
            raise InputError(
                f'a {spec.text("excitation.kind")} has many frequencies; give one by --omega or '
                '--frequency, or a range of them to qzs-rig frf or bifurcation --vary omega'
            )
        omega = own.omega(spec.number('excitation.frequency'))
    else:
        given = PAPER_FREQUENCY if options.frequency is None else options.frequency
        omega = given / own.omega0
    if not (omega > 0.0 and math.isfinite(omega)):
        raise InputError(f'frequency {omega:g}; give a number above 0')
    return omega


def band_of(
    options: argparse.Namespace, spec: RunSpec, own: Oscillator
) -> tuple[float, float] | None:
    """Lowest and highest Ω that the scenario passes, None without one."""
    if not _scenario(options, spec):
        return None
    low, high = range_hz(spec)
    return own.omega(low), own.omega(high)


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
