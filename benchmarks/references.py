"""Where theory must land: published or independently computed figures, ours, and the difference."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from typing import NamedTuple

from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.mechanics.restoring.law import PAPER_DESIGN, RestoringLaw
from qzs_rig.theory.balance.frequency_response import frequency_response
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.theory.single_term import single_term
from qzs_rig.units import DOFS


class Row(NamedTuple):
    """One figure."""

    name: str
    reference: float
    ours: float
    allowed: float


def duffing() -> Iterator[Row]:
    """x'' + 0.05 x' + x + 0.1 x³ = 0.18 cos Ωt, NLvib example 01 (Krack and Gross 2019)."""
    law = RestoringLaw(
        'duffing', 'NLvib', lambda _: ((1.0, 0.0, 0.1),) * 4, weighted=False, odd=DOFS
    )
    own = Oscillator(law, 'vertical', PAPER_DESIGN, 0.025, 0.18, falloff=2)
    yield from folds(own, 'Duffing', (0.5, 1.6), (1.2696019555, 1.1157002518), 5e-8)


def folds(
    own: Oscillator,
    name: str,
    omega: tuple[float, float],
    references: tuple[float, ...],
    allowed: float,
) -> Iterator[Row]:
    """Each reference beside the nearest fold found."""
    began = time.perf_counter()
    found = frequency_response(own, *omega)
    took = time.perf_counter() - began
    points = sum(len(branch.omega) for branch in found.branches)
    every = ', '.join(f'{event.omega:.6f}' for event in found.folds)
    print(
        f'{name}: {len(found.branches)} branches, {points} points, {found.harmonics} harmonics, '
        f'{took:.2f} s; folds {every}'
    )
    for value in references:
        near = min(found.folds, key=lambda event: abs(event.omega - value))
        yield Row(f'{name}, fold', value, near.omega, allowed)


def model_section_5() -> Iterator[Row]:
    """`symmetric` vertical, one harmonic, zeta = 0.07, amplitude 1/12."""
    found = single_term(0.0, 4.2, 0.07, 1 / 12, [0.2, 0.5]).T
    expected = ((0.2, (1.840268,)), (0.5, (0.314178, 2.739556, 3.830048)))
    for row, (omega, values) in enumerate(expected):
        for column, value in enumerate(values):
            ours = float(found[row, column])
            yield Row(f'one harmonic, T at {omega:g}', value, ours, 1e-6)


def rows() -> Iterator[Row]:
    """Every reference."""
    yield from duffing()
    taylor = Oscillator(RESTORING['taylor'], 'vertical', PAPER_DESIGN, 0.07, 0.6)
    yield from folds(taylor, 'taylor', (0.02, 3.0), (0.4724070372, 0.2071890982), 1e-8)
    closed = Oscillator(RESTORING['closed_form'], 'vertical', PAPER_DESIGN, 0.02, 0.6)
    yield from folds(closed, 'closed_form', (0.25, 1.6), (0.3176651784, 0.2964333635), 1e-8)
    yield from model_section_5()


def main() -> int:
    """Print the table; 1 where a figure is off."""
    table = list(rows())
    print(f'\n{"figure":28}{"reference":>16}{"ours":>16}{"difference":>13}{"allowed":>10}')
    for row in table:
        gap = abs(row.ours - row.reference)
        print(f'{row.name:28}{row.reference:16.10f}{row.ours:16.10f}{gap:13.1e}{row.allowed:10.0e}')
    return int(any(not math.fabs(row.ours - row.reference) <= row.allowed for row in table))


if __name__ == '__main__':
    raise SystemExit(main())
