"""Many oscillators at once: the platforms of a chunk made nondimensional, column by column."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from qzs_rig.campaign.task import Harvest, Points
from qzs_rig.mechanics.design import Design
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import RestoringLaw
from qzs_rig.parameters import Parameter
from qzs_rig.samples import Array
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import DOFS, GRAVITY, TRANSLATIONS

MOTION = (
    Parameter('dof', str, 'vertical', '', 'degree of freedom', choices=DOFS),
    Parameter(
        'amplitude', float, None, '', 'base amplitude Ĥ over L20, rotations in rad', 0.0, above=True
    ),
    Parameter(
        'displacement',
        float,
        None,
        'm or rad',
        'base amplitude, instead of amplitude',
        0.0,
        above=True,
        replaces=('amplitude',),
    ),
)
"""What a point says of the base motion."""
FREQUENCY = (
    Parameter('omega', float, None, '', 'frequency Ω over omega0', 0.0, above=True),
    Parameter(
        'frequency', float, None, 'Hz', 'instead of omega', 0.0, above=True, replaces=('omega',)
    ),
)
AMPLITUDE_NEEDED = ('amplitude', 'displacement')
FREQUENCY_NEEDED = ('omega', 'frequency')


@dataclass(frozen=True)
class Bank:
    """n oscillators of one law and one motion, see Oscillator; `rows` are their rows in the chunk.

    `ratios` (6, n) are the fields of Design; the other arrays are (n,), `omega0` in rad/s.
    """

    rows: NDArray[np.int64]
    law: RestoringLaw
    dof: str
    ratios: Array
    zeta: Array
    amplitude: Array
    load: Array
    omega0: Array

    def __len__(self) -> int:
        return len(self.rows)

    def oscillator(self, n: int, falloff: int = 0) -> Oscillator:
        """One of them."""
        design = Design(*self.ratios[:, n].tolist())
        motion = (float(self.zeta[n]), float(self.amplitude[n]), float(self.load[n]))
        return Oscillator(self.law, self.dof, design, *motion, falloff)


def banks(points: Points, harvest: Harvest) -> Iterator[Bank]:
    """A bank for each law and motion among `points`, those in order of appearance.

    Springs that would not incline, and a payload taken off whole, go to `harvest` as failed.
    """
    ratios, good = _ratios(points, harvest)
    words = np.char.add(np.char.add(points.word('platform.law'), ' '), points.word('dof'))
    kinds, firsts, which = np.unique(words, return_index=True, return_inverse=True)
    for kind in np.argsort(firsts):
        rows = np.flatnonzero((which == kind) & good)
        if rows.size:
            law, dof = str(kinds[kind]).split(' ')
            yield _bank(points, ratios, rows, law, dof)


def omegas(points: Points, bank: Bank) -> Array:
    """Ω (n,) of the bank's points."""
    if points.has('frequency'):
        return np.asarray(2.0 * np.pi * points.number('frequency')[bank.rows] / bank.omega0)
    return points.number('omega')[bank.rows]


def _ratios(points: Points, harvest: Harvest) -> tuple[Array, NDArray[np.bool_]]:
    """mechanics.platform.platform_design in columns, and which rows can be built."""
    k1, L20 = points.number('platform.k1'), points.number('platform.L20')

    def ratio(hat: str, si: str, scale: Array) -> Array:
        if points.has(f'platform.{hat}'):
            return points.number(f'platform.{hat}')
        return np.asarray(points.number(f'platform.{si}') / scale)

    A, k3 = ratio('A', 'k2', k1), ratio('k3_hat', 'k3', k1)
    L1, L0 = ratio('L1_hat', 'L1', L20), ratio('L0_hat', 'L0', L20)
    upright = L1 < 1.0
    loaded = points.number('platform.m') + points.number('platform.payload_trim') > 0.0
    harvest.fail(
        np.flatnonzero(~upright), 'platform.L1 / L20 must be below 1: springs would not incline'
    )
    harvest.fail(
        np.flatnonzero(~loaded), 'platform.payload_trim takes more than platform.m; nothing moves'
    )
    a = np.sqrt(1.0 - np.where(upright, L1 * L1, 0.0))
    return np.stack([A, k3, L1, L0, a, k3 * L1]), upright & loaded


def _bank(points: Points, ratios: Array, rows: NDArray[np.int64], law: str, dof: str) -> Bank:
    """mechanics.platform.Platform.from_spec in columns."""
    own = ratios[:, rows]
    k1, L20, m, trim = (
        points.number(f'platform.{name}')[rows] for name in ('k1', 'L20', 'm', 'payload_trim')
    )
    L0, m = own[Design._fields.index('L0')] * L20, m + trim
    mass = _mass(points, rows, dof, m, L0)
    stiffness = k1 if dof in TRANSLATIONS else k1 * L20 * L0
    return Bank(
        rows=rows,
        law=RESTORING[law],
        dof=dof,
        ratios=own,
        zeta=_zeta(points, rows, dof, 2.0 * np.sqrt(stiffness * mass), 2.0 * np.sqrt(k1 * m)),
        amplitude=_amplitude(points, rows, L20 if dof in TRANSLATIONS else np.ones_like(L20)),
        load=trim * GRAVITY / (k1 * L20) if dof == 'vertical' else np.zeros(len(rows)),
        omega0=np.sqrt(stiffness / mass),
    )


def _mass(points: Points, rows: NDArray[np.int64], dof: str, m: Array, L0: Array) -> Array:
    if dof in TRANSLATIONS:
        return m
    name, share = ('I_vm', 2.0) if dof == 'vertical_rotation' else ('I_hm', 4.0)
    if points.has(f'platform.{name}'):
        return points.number(f'platform.{name}')[rows]
    return np.asarray(m * L0**2 / share)


def _zeta(
    points: Points, rows: NDArray[np.int64], dof: str, critical: Array, vertical: Array
) -> Array:
    if points.has('platform.zeta'):
        return points.number('platform.zeta')[rows]
    if points.has(f'platform.C.{dof}'):
        return np.asarray(points.number(f'platform.C.{dof}')[rows] / critical)
    return np.asarray(points.number('platform.C.vertical')[rows] / vertical)


def _amplitude(points: Points, rows: NDArray[np.int64], length: Array) -> Array:
    if points.has('displacement'):
        return np.asarray(points.number('displacement')[rows] / length)
    return points.number('amplitude')[rows]
