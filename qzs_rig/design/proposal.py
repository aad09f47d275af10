"""A platform for a wish: closed forms, and two bracketed searches.

The static load ties force to length: b k1 L20 = m g, so omega0² = k1/m = g/(b L20). Everything
else is a ratio: a, k3_hat, L0_hat and, by (16), A.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np

from qzs_rig import scenario
from qzs_rig.design.vertical_motion import Motion
from qzs_rig.errors import InputError
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import Design
from qzs_rig.mechanics.statics import suspension_for
from qzs_rig.parameters import RunSpec
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import GRAVITY, QUANTITIES

HALF_SPAN = 0.5
"""a of the paper: suspension springs 60 degrees steep before loading. a = 2/3 has the least cubic
term, by 16 %, but asks for suspension springs twice as stiff and a plate half as large."""
LEAF = (0.01, 1.0)
"""k3_hat, from leaf springs a hundredth of the central spring to the largest triple of Fig 9."""
REACH = 0.2
"""Stroke over L20, at most. Up to there the cubic law, and with it theory, is good to a tenth."""
LEVEL_MARGIN = 0.9
"""Of the critical amplitude, at most."""
TIP_MARGIN = 0.9
"""L0_hat over k3_hat/A, which (19) makes 1: a tenth of the leaf stiffness keeps the plate up."""
SETTLED = 0.5
"""Onset at vanishing level over the wanted one, at most (erratum E20)."""
ROOM = 5.0
"""Longest suspension spring worth proposing, m."""
BELOW, ABOVE = 0.4, 2.5
"""Band over the onset."""
PERIODS = 100.0
"""Periods of the onset frequency an octave."""
OCTAVES = 2.65
"""log2(ABOVE/BELOW)."""
SAMPLES = 125.0
"""A period of the highest frequency."""


@dataclass(frozen=True)
class Wish:
    """Payload (kg), onset (Hz) above which T < 1, stroke (m, relative motion to either side that
    the platform may use), amplitude of the base in the unit of `held`, damping ratio."""

    mass: float
    onset: float
    stroke: float
    level: float
    held: str = 'acceleration'
    zeta: float = 0.1

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            name = self.held if item.name == 'level' and self.held == 'displacement' else item.name
            if item.name != 'held' and not (value > 0.0 and math.isfinite(value)):
                raise InputError(f'--{name} {value:g} must be a number above 0')
        if not self.zeta <= 1.0:
            raise InputError(
                f'--zeta {self.zeta:g} is beyond critical damping, where nothing isolates; '
                'give 1 or less'
            )
        if self.held not in QUANTITIES:
            raise InputError(f'held is {self.held!r}; known: {", ".join(QUANTITIES)}')
        if self.held == 'displacement' and not self.stroke > self.level:
            raise InputError(
                f'--stroke {self.stroke:g} m is no more than --displacement {self.level:g} m, yet '
                'an isolated plate stands still and moves against the base by all of it; '
                'allow more --stroke'
            )

    @property
    def level_text(self) -> str:
        """The amplitude of the base with its unit."""
        units = dict(zip(QUANTITIES, ('m', 'm/s', 'm/s²'), strict=True))
        return f'{self.level:g} {units[self.held]}'


class Proposal(NamedTuple):
    """Springs in N/m (k2 and k3 in all), lengths in m; `why` says the rule of each choice."""

    wish: Wish
    design: Design
    k1: float
    k2: float
    k3: float
    L1: float
    L20: float
    L0: float
    why: dict[str, str]

    @property
    def motion(self) -> Motion:
        """The vertical motion under the level of the wish."""
        return motion(self.wish, self.design, self.L20)


def propose(wish: Wish) -> Proposal:
    """The softest-sprung platform that fulfils the wish.

    L20 is the least that gives the onset and keeps the stroke within REACH. k3_hat is the largest
    whose relative motion fits the stroke and whose even term (E20) leaves the onset alone: a
    larger one means weaker helical springs and a larger plate, but swings farther. Raises
    InputError where no such platform exists.
    """
    k3 = _largest_leaf(wish)
    design = ratios(k3)
    L20 = spring_length(wish, design)
    if L20 > ROOM:
        raise InputError(
            f'--onset {wish.onset:g} Hz at {wish.level_text} and --stroke {wish.stroke:g} m takes '
            f'suspension springs {L20:.3g} m long, beyond {ROOM:g} m; raise --onset or --zeta, or '
            'lower the level or the stroke'
        )
    k1 = wish.mass * GRAVITY / (design.b * L20)
    lengths = {'L1': design.L1 * L20, 'L20': L20, 'L0': design.L0 * L20}
    return Proposal(
        wish, design, k1=k1, k2=design.A * k1, k3=k3 * k1, **lengths, why=_why(wish, design, L20)
    )


def ratios(k3: float) -> Design:
    """A by (16), L0_hat by (19) with TIP_MARGIN."""
    L1, A = math.sqrt(1.0 - HALF_SPAN**2), suspension_for(k3, HALF_SPAN)
    return Design((A, k3, L1, TIP_MARGIN * k3 / A, HALF_SPAN, k3 * L1))


def motion(wish: Wish, design: Design, L20: float) -> Motion:
    """The vertical motion with c1 = 0 by (16) and omega0² = g/(b L20)."""
    omega0 = math.sqrt(GRAVITY / (design.b * L20))
    still = Oscillator(
        RESTORING['corrected'], 'vertical', design, wish.zeta, 0.0, omega0=omega0, length=L20
    )
    return Motion(still.under(wish.level, wish.held))


def spring_length(wish: Wish, design: Design) -> float:
    """The least L20 that has the onset, the stroke and, for a displacement, the level margin."""
    return max(_for_onset(wish, design), wish.stroke / REACH)


def _for_onset(wish: Wish, design: Design) -> float:
    """Acceleration: h = level b/g at omega0 whatever L20 is, so Omega is known and L20 follows
    from omega0. Displacement: a bisection from the length that has the level margin."""
    wanted = 2.0 * math.pi * wish.onset
    if wish.held == 'acceleration':
        omega = motion(wish, design, 1.0).omega_onset
        assert omega is not None
        return float(GRAVITY * omega**2 / (design.b * wanted**2))
    critical = motion(wish, design, 1.0).critical_hat
    assert critical is not None

    def late(L20: float) -> bool:
        case = motion(wish, design, L20)
        return (case.omega_onset or 0.0) * case.oscillator.omega0 > wanted

    short = wish.level / (LEVEL_MARGIN * critical)
    if not late(short):
        return short
    long = 2.0 * short  # at sqrt(2) below the critical amplitude T is below 1 everywhere
    return _change(late, short, long)[1]


def _largest_leaf(wish: Wish) -> float:
    def with_leaf(k3: float) -> Motion:
        design = ratios(k3)
        return motion(wish, design, spring_length(wish, design))

    def fits(k3: float) -> bool:
        case = with_leaf(k3)
        return case.settled <= SETTLED * wish.onset and case.relative <= wish.stroke

    low, high = LEAF
    if fits(high):
        return high
    least = with_leaf(low)
    if least.settled > SETTLED * wish.onset:
        raise InputError(
            f'--onset {wish.onset:g} Hz is too low for so small a platform: at vanishing level '
            f'it isolates from {least.settled:.3g} Hz, and that shall be half of the onset; '
            'raise --onset, or allow more --stroke for longer springs'
        )
    if least.relative > wish.stroke:
        raise InputError(
            f'--stroke {wish.stroke:g} m is too short: with --onset {wish.onset:g} Hz and --zeta '
            f'{wish.zeta:g} the plate swings {least.relative:.3g} m at {wish.level_text}; '
            'allow more --stroke, raise --onset or --zeta, or lower the level'
        )
    return _change(fits, low, high)[0]


def _change(holds: Callable[[float], bool], low: float, high: float) -> tuple[float, float]:
    """The last of the values from `low` to `high` for which `holds` is true, and the next, for
    which it is false: neighbours 2^-18 of the range apart."""
    values = np.linspace(low, high, 2**18 + 1)
    k = bisect_left(values, True, lo=1, hi=2**18, key=lambda value: not holds(float(value)))
    return float(values[k - 1]), float(values[k])


def _why(wish: Wish, design: Design, L20: float) -> dict[str, str]:
    stroke_rules = wish.stroke / REACH >= L20
    return {
        'L1': 'sqrt(3)/2 L20: a = 1/2 as in the paper, suspension springs 60 degrees steep',
        'L20': f'stroke / {REACH:g}, so that the stroke stays soft; the onset would do with less'
        if stroke_rules
        else 'the least that has the onset (or 0.9 of the critical displacement) at this level',
        'L0': f'{TIP_MARGIN:g} L20 k3_hat/A: (19) with a tenth to spare against tipping',
        'k1': 'm g/(b L20): the static load b of (8) is the weight at the working point (E21)',
        'k2': 'A k1 with A = (1 + k3_hat) a/(1 - a): (16), no vertical stiffness',
        'k3': f'm g/L1; k3_hat = {design.k3:.4g} is the largest whose swing at this '
        'level fits the stroke and whose onset at vanishing level (E20) is half of the wanted',
    }


def trial(p: Proposal) -> RunSpec:
    """A logarithmic sweep there and back at the level of the wish, with an ideal sensor.

    The band is around the onset that theory gives, or the wanted one where T < 1 throughout.
    A shaker that starts at 1 Hz has its limit moved down to the band.
    """
    onset = p.motion.response().onset or p.wish.onset
    low, high = BELOW * onset, ABOVE * onset
    values: dict[str, Any] = {
        'run.rate': float(round(SAMPLES * high)) or 1.0,
        'excitation.kind': 'sweep',
        'excitation.direction': 'there_and_back',
        'excitation.spacing': 'log',
        'excitation.frequency_low': low,
        'excitation.frequency_high': high,
        'excitation.duration': 2.0 * OCTAVES * PERIODS / onset,
        'excitation.ramp': 6.0 / low,
        'excitation.quantity': p.wish.held,
        'excitation.amplitude.vertical': p.wish.level,
        'platform.law': 'corrected',
        **{f'platform.{name}': getattr(p, name) for name in ('k1', 'k2', 'k3', 'L1', 'L20', 'L0')},
        'platform.m': p.wish.mass,
        'platform.zeta': p.wish.zeta,
        'sensor.kind': 'ideal',
    }
    if low < 1.0:
        values['shaker.frequency_low'] = low
    return scenario.of(values)


def trial_text(p: Proposal) -> str:
    """The scenario file: what it is for, then the parameters."""
    wish = p.wish
    head = (
        f'# Proposed by qzs-rig design: {wish.mass:g} kg, onset {wish.onset:g} Hz or below at '
        f'{wish.level_text}, stroke {wish.stroke:g} m, zeta {wish.zeta:g}.\n'
    )
    return head + trial(p).to_yaml()
