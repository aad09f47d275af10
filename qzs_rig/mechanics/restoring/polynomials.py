"""Laws of third order: expansions of the closed form, (20)-(23), (27); the leaf springs alone."""

from __future__ import annotations

from qzs_rig.mechanics.restoring import closed_form
from qzs_rig.mechanics.restoring.law import Design, RestoringLaw, Taylor
from qzs_rig.units import DOFS


def _printed(design: Design) -> Taylor:
    """d1…d8 as printed, less the constant b that the payload balances (erratum E18):
    (d3, d2, d1), (0, d4, d5), (d6, 0, d7), (-d8, d8, d8/2)."""
    A, k3, L1, L0, a, b = design.ratios
    d8 = A * L0 - k3
    return (
        (A + 1.0 - A / a + k3, -b / (2.0 * a**2), A / (2.0 * a**3) - k3 / (2.0 * a**2)),
        (0.0, -3.0 * A * a + 3.0 * A * a**3, 1.0 / (2.0 * L1**2)),
        (k3 * L0, 0.0, -A * L0**3 / 2.0 - k3 * L0),
        (-d8, d8, d8 / 2.0),
    )


def _symmetric(design: Design) -> Taylor:
    """The odd terms of (27), for which the paper's own harmonic balance (29) is."""
    return tuple((c1, 0.0, c3) for c1, _, c3 in _printed(design))


def _linear(design: Design) -> Taylor:
    """Leaf terms of Eqs (8), (13), (15) at the working point; sideways the leaf's own k3."""
    k3 = (design.k3, 0.0, 0.0)
    return k3, k3, (design.k3 * design.L0, 0.0, 0.0), k3


TAYLOR = RestoringLaw(
    'taylor',
    'Wang et al. 2022, Eqs (20)-(23) with errata E5, E6',
    closed_form.taylor,
    odd=('vertical_rotation',),
)

PRINTED = RestoringLaw('printed', 'Wang et al. 2022, Eq (27)', _printed, odd=('vertical_rotation',))

SYMMETRIC = RestoringLaw(
    'symmetric', 'Wang et al. 2022, Eq (27), odd terms', _symmetric, weighted=False, odd=DOFS
)

LINEAR = RestoringLaw(
    'linear',
    'Wang et al. 2022, section 5 (linear mode), erratum E10',
    _linear,
    weighted=False,
    odd=DOFS,
)
