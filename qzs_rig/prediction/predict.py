"""What theory says of a run, before it begins."""

from __future__ import annotations

from dataclasses import replace

from qzs_rig.mechanics.platform import Platform
from qzs_rig.parameters import RunSpec
from qzs_rig.prediction import balance, one_term
from qzs_rig.prediction.curve import Prediction
from qzs_rig.prediction.scale import Scale
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.units import DOFS


def predict(spec: RunSpec) -> tuple[Prediction, ...]:
    """One prediction for each driven degree of freedom of the run `spec`, in their order.

    By harmonic balance of the restoring law; where that finds nothing, by one harmonic of its
    cubic part, and `method` says so. A coupled platform is predicted by its four projections.
    """
    platform = Platform.from_spec(spec)
    return tuple(
        _predict(spec, platform, Scale.of(spec, platform, dof))
        for dof in DOFS
        if spec.number(f'excitation.amplitude.{dof}')
    )


def _predict(spec: RunSpec, platform: Platform, scale: Scale) -> Prediction:
    k = DOFS.index(scale.dof)
    oscillator = Oscillator.of(spec, scale.dof, scale.amplitude, scale.falloff)
    found = balance.predict(scale, oscillator, platform.rest[k])
    found = found or one_term.predict(scale, *platform.cubic[k], platform.zeta[k])
    return replace(found, label=f'{found.label}, uncoupled') if platform.coupled else found
