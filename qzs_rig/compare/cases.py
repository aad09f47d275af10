"""The single-term theory that belongs to a run: from its parameters to theory curves."""

from __future__ import annotations

from qzs_rig.compare.theory_overlay import TheoryCase, TheoryCurve, theory_curve
from qzs_rig.dof import DOFS
from qzs_rig.mechanics.platform import Platform
from qzs_rig.parameters import RunSpec

MARGIN = 1.02
"""Theory is drawn a little beyond the band of the run."""


def theory_of(spec: RunSpec) -> list[TheoryCurve]:
    """One curve for each driven degree of freedom, from the cubic part of the restoring law.

    Exact (to one harmonic) for the cubic laws; for the others good where the relative motion is
    small against the platform.
    """
    platform = Platform.from_spec(spec)
    low, high = _band(spec)
    cubic = platform.cubic
    curves = []
    for k, dof in enumerate(DOFS):
        amplitude = spec.number(f'excitation.amplitude.{dof}')
        if amplitude:
            case = TheoryCase(
                dof,
                *cubic[k],
                zeta=platform.zeta[k],
                omega0=platform.omega0[k],
                length=abs(platform.length[k]),
                amplitude=amplitude,
                held=spec.text('excitation.quantity'),
            )
            curves.append(theory_curve(case, low / MARGIN, high * MARGIN))
    return curves


def _band(spec: RunSpec) -> tuple[float, float]:
    if spec.text('excitation.kind') == 'sine':
        f = spec.number('excitation.frequency')
        return 0.5 * f, 2.0 * f
    return spec.number('excitation.frequency_low'), spec.number('excitation.frequency_high')
