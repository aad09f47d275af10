"""What theory says of a run, before it begins."""

from __future__ import annotations

from qzs_rig.dof import DOFS
from qzs_rig.mechanics.platform import Platform
from qzs_rig.parameters import RunSpec
from qzs_rig.prediction import one_term
from qzs_rig.prediction.curve import Prediction
from qzs_rig.prediction.scale import Scale


def predict(spec: RunSpec) -> tuple[Prediction, ...]:
    """One prediction for each driven degree of freedom of the run `spec`, in their order."""
    platform = Platform.from_spec(spec)
    return tuple(
        one_term.predict(Scale.of(spec, platform, dof), *platform.cubic[k], platform.zeta[k])
        for k, dof in enumerate(DOFS)
        if spec.number(f'excitation.amplitude.{dof}')
    )
