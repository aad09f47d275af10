"""The platform: mass, damping and restoring law of four degrees of freedom, in SI."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from qzs_rig.errors import InputError
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import Design, RestoringLaw, root
from qzs_rig.mechanics.statics import equilibrium
from qzs_rig.parameters import Parameter, RunSpec, positive
from qzs_rig.units import DOFS, GRAVITY, ROTATIONS, TRANSLATIONS


def parameters() -> tuple[Parameter, ...]:
    """What describes a platform: its springs, payload and damping, what the laws of RESTORING ask
    for, and how it is stepped."""
    laws = RESTORING.values()
    return (
        Parameter(
            'platform.law',
            str,
            'corrected',
            '',
            'restoring law of the springs',
            choices=tuple(RESTORING),
        ),
        *_SPRINGS,
        # two laws may share a parameter
        *dict.fromkeys(parameter for law in laws for parameter in law.parameters),
        *dict.fromkeys(parameter for law in laws for parameter in law.couples),
        Parameter('platform.substeps', int, 1, '', 'integration steps a sample', 1, 1000),
        Parameter(
            'platform.kernel',
            str,
            'auto',
            '',
            'who steps: the interpreter, numba (the same bits, faster once loaded), or what starts '
            'and runs sooner',
            choices=('auto', 'python', 'numba'),
        ),
    )


_SPRINGS = (
    positive('platform.k1', 20000.0, 'N/m', 'central spring (Table 1)'),
    Parameter('platform.k2', float, 22000.0, 'N/m', 'suspension springs (Table 1)', 0.0),
    Parameter('platform.k3', float, 2000.0, 'N/m', 'leaf springs (Table 1)', 0.0),
    positive(
        'platform.L1',
        0.6 * math.sqrt(3.0) / 2.0,
        'm',
        'stretch of the central spring; Table 1 prints 0.52, which is sqrt(3)/2 L20 rounded',
    ),
    positive('platform.L20', 0.6, 'm', 'suspension spring (Table 1)'),
    positive('platform.L0', 0.06, 'm', 'radius of the top plate (Table 1)'),
    positive('platform.m', 50.0, 'kg', 'payload (Table 1), balanced at the working point'),
    Parameter(
        'platform.payload_trim',
        float,
        0.0,
        'kg',
        'payload put on top of m without rebalancing (negative: taken off): it moves with the '
        'plate, and its weight shifts the rest position off the working point',
    ),
    positive(
        'platform.I_vm', None, 'kg m²', 'inertia about the vertical axis; unset: a disc, m L0²/2'
    ),
    positive(
        'platform.I_hm', None, 'kg m²', 'inertia about a horizontal axis; unset: a disc, m L0²/4'
    ),
    *(
        Parameter(f'platform.C.{dof}', float, 44.3, 'N s/m', 'damping (Table 1)', 0.0)
        for dof in TRANSLATIONS
    ),
    *(
        Parameter(
            f'platform.C.{dof}',
            float,
            None,
            'N m s/rad',
            'damping; unset: the damping ratio of the vertical (erratum E19)',
            0.0,
        )
        for dof in ROTATIONS
    ),
    Parameter(
        'platform.A', float, None, '', 'k2/k1, instead of k2', 0.0, replaces=('platform.k2',)
    ),
    Parameter(
        'platform.k3_hat', float, None, '', 'k3/k1, instead of k3', 0.0, replaces=('platform.k3',)
    ),
    positive('platform.L1_hat', None, '', 'L1/L20, instead of L1', 1.0, replaces=('platform.L1',)),
    positive('platform.L0_hat', None, '', 'L0/L20, instead of L0', replaces=('platform.L0',)),
    Parameter(
        'platform.zeta',
        float,
        None,
        '',
        'damping ratio C omega0/(2 k1) of all degrees of freedom, instead of C',
        0.0,
        replaces=tuple(f'platform.C.{dof}' for dof in DOFS),
    ),
    Parameter(
        'platform.coupled',
        bool,
        True,
        '',
        'law geometric only: all six degrees of freedom coupled, or the four each by itself',
    ),
)


@dataclass(frozen=True)
class Platform:
    """M w'' + C w' + F(w) = -M v'' for w = u - v, each degree of freedom by itself (25)-(27).

    All tuples are in the order of DOFS. `length` scales motion: w_hat = w / length, negative for
    `vertical` because the paper's x points down and the rig's z up; 1 for rotations. `stiffness`
    scales force, F(w) = stiffness length F_hat(w_hat): k1 for translations, k1 L20 L0 otherwise.
    `load` is the unbalanced weight (over k1 L20). Numbers of a spec with columns are (n,).
    `coupled`: this is only the projection of mechanics.rigid_body, which moves instead.
    """

    law: RestoringLaw
    design: Design
    mass: tuple[float, ...]
    damping: tuple[float, ...]
    length: tuple[float, ...]
    stiffness: tuple[float, ...]
    load: tuple[float, ...] = (0.0,) * len(DOFS)
    coupled: bool = False

    @classmethod
    def from_spec(cls, spec: RunSpec) -> Platform:
        """The platform of a run; raises InputError for one that cannot be built."""
        k1, L20 = (spec.number(f'platform.{name}') for name in ('k1', 'L20'))
        design = platform_design(spec)
        trim = spec.number('platform.payload_trim')
        m, L0 = spec.number('platform.m') + trim, design.L0 * L20
        law, load = RESTORING[spec.text('platform.law')], trim * GRAVITY / (k1 * L20)
        if not coupled(spec):
            refuse_coupled_words(spec)
        if np.ndim(load) == 0:
            equilibrium(law, design, load)  # refuses a weight that the springs cannot hold
        I_vm, I_hm = (spec.optional(f'platform.{name}') for name in ('I_vm', 'I_hm'))
        disc = m * L0**2
        mass = (
            m,
            m,
            disc / 2.0 if I_vm is None else I_vm,
            disc / 4.0 if I_hm is None else I_hm,
        )
        stiffness = (k1, k1, k1 * L20 * L0, k1 * L20 * L0)
        return cls(
            law=law,
            design=design,
            mass=mass,
            damping=_damping(spec, mass, stiffness),
            length=(-L20, L20, 1.0, 1.0),
            stiffness=stiffness,
            load=(load, 0.0, 0.0, 0.0),
            coupled=coupled(spec),
        )

    @cached_property
    def rest(self) -> tuple[float, ...]:
        """Relative motion over `length` at which the law holds `load`."""
        return equilibrium(self.law, self.design, self.load[0]), 0.0, 0.0, 0.0

    @property
    def cubic(self) -> tuple[tuple[float, float], ...]:
        """(c1, c3) of the law about the rest position of each degree of freedom."""
        return self.law.cubic(self.design, self.rest[0])

    @property
    def omega0(self) -> tuple[float, ...]:
        """Reference frequency sqrt(stiffness/mass) of each degree of freedom in rad/s."""
        return tuple(root(s / m) for s, m in zip(self.stiffness, self.mass, strict=True))

    @property
    def zeta(self) -> tuple[float, ...]:
        """Damping ratio C/(2 M omega0) of each degree of freedom."""
        return tuple(
            c / (2.0 * m * w) for c, m, w in zip(self.damping, self.mass, self.omega0, strict=True)
        )

    def cautions(self, driven: tuple[bool, ...]) -> list[str]:
        """What a user should know before trusting a run of the `driven` degrees of freedom."""
        said = []
        for dof, (c1, _), moves in zip(DOFS, self.cubic, driven, strict=True):
            # where the coupled plate tips, its own modes tell
            if moves and c1 < 0.0 and not self.coupled:
                said.append(
                    f'{dof} has negative stiffness ({c1:.4g}) where it rests and will tip '
                    'over to a side; k3_hat >= A L0_hat and condition (16) avoid it'
                )
        if driven[DOFS.index('horizontal')] and 'horizontal' not in self.law.odd:
            said.append(
                f'{self.law.name} slides into a false well horizontally (erratum E4); '
                'use platform.law corrected'
            )
        if self.load[0]:
            said.append(
                f'payload_trim moves the rest position {1e3 * self.rest[0] * self.length[0]:+.4g} '
                f'mm from the working point (z up); stiffness there {self.cubic[0][0]:.4g} k1'
            )
        return said


def coupled(spec: RunSpec) -> bool:
    """Whether all six degrees of freedom move together."""
    law = RESTORING[spec.text('platform.law')]
    return bool(law.couples) and spec.flag('platform.coupled')


def refuse_coupled_words(spec: RunSpec) -> None:
    """InputError for what is given of the coupled platform where each motion is by itself."""
    for parameter in RESTORING[spec.text('platform.law')].couples:
        if parameter.name in spec.given:
            raise InputError(
                f'{parameter.name}{_shown(spec.number(parameter.name))} has no meaning for single '
                'degrees of freedom; leave it out, or take all six together: a run with '
                'platform.coupled, or qzs-rig modes'
            )


def refuse_coupled(spec: RunSpec) -> None:
    """InputError where all six degrees of freedom move together, for what solves one of them."""
    if coupled(spec):
        raise InputError(
            'platform.law geometric couples six degrees of freedom, and this solves one; set '
            'platform.coupled=false to take each by itself, or let frf solve all six'
        )


def platform_design(spec: RunSpec) -> Design:
    """The design of a platform's law; raises InputError for one that cannot be built."""
    for where, why in unbuildable(spec):
        if np.any(where):
            raise InputError(why)
    k1, L20 = spec.number('platform.k1'), spec.number('platform.L20')
    law = RESTORING[spec.text('platform.law')]
    return Design.of(
        _ratio(spec, 'A', 'k2', k1),
        _ratio(spec, 'k3_hat', 'k3', k1),
        _ratio(spec, 'L1_hat', 'L1', L20),
        _ratio(spec, 'L0_hat', 'L0', L20),
        *(spec.number(parameter.name) for parameter in law.parameters),
    )


def unbuildable(spec: RunSpec) -> tuple[tuple[Any, str], ...]:
    """Why a platform cannot be built, each with whether that is so: a truth, or (n,) of them."""
    L1 = _ratio(spec, 'L1_hat', 'L1', spec.number('platform.L20'))
    m, trim = spec.number('platform.m'), spec.number('platform.payload_trim')
    return (
        (
            L1 >= 1.0,
            f'platform.L1 / L20{_shown(L1)} must be below 1: suspension springs would not '
            'incline; shorten L1 or lengthen L20',
        ),
        (
            m + trim <= 0.0,
            f'platform.payload_trim{_shown(trim)} takes more than the payload{_shown(m)} kg; '
            'keep platform.m + platform.payload_trim above 0',
        ),
    )


def _shown(value: Any) -> str:
    """The value, where there is one and not a column of them."""
    return '' if np.ndim(value) else f' = {value:g}'


def _ratio(spec: RunSpec, hat: str, si: str, scale: float) -> float:
    value = spec.optional(f'platform.{hat}')
    return spec.number(f'platform.{si}') / scale if value is None else value


def _damping(
    spec: RunSpec, mass: tuple[float, ...], stiffness: tuple[float, ...]
) -> tuple[float, ...]:
    critical = [2.0 * root(s * m) for s, m in zip(stiffness, mass, strict=True)]
    zeta = spec.optional('platform.zeta')
    if zeta is not None:
        return tuple(zeta * c for c in critical)
    given = [spec.optional(f'platform.C.{dof}') for dof in DOFS]
    vertical = given[0] if given[0] is not None else 0.0
    same_ratio = [vertical / critical[0] * c for c in critical]
    return tuple(
        c if c is not None else default for c, default in zip(given, same_ratio, strict=True)
    )
