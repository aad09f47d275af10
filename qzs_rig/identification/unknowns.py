"""The parameters that are fitted: names of the run's own table, each with its start and bounds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from qzs_rig.errors import InputError
from qzs_rig.mechanics.platform import Platform
from qzs_rig.mechanics.restoring import RESTORING
from qzs_rig.parameters import Parameter, RunSpec, unknown_parameter
from qzs_rig.samples import Array
from qzs_rig.units import DOFS

TRIM = 'platform.payload_trim'
DEFAULT = ('platform.zeta', 'platform.A', TRIM)
STEP = 1e-5
"""Of a parameter's scale, for central differences of the balance at fixed motion: truncation
(1e-10) and rounding (1e-11) then weigh about the same, as the balance is smooth and of order 1."""
TRIM_SHARE = 0.01
"""Of the payload: a trim known no better than this is not known."""
WORTH = 0.25
"""Relative uncertainty of any other parameter from which on it is not known."""
NEAR = 1e-3
"""Of its scale, to which a search inside bounds comes to one."""
FARTHEST = 30.0
"""Times the start, up or down, that a parameter is looked for."""


@dataclass(frozen=True)
class Unknowns:
    """The fitted parameters of `spec`, in order: names as --set knows them, units, arrays (p,).

    Values begin at `start` and stay within `low` and `high`. `reference` is what changes are
    relative to (the payload for a trim, else the start); `scale` is the standard deviation at
    which a parameter counts as not determined, and the measure of a step.
    """

    spec: RunSpec
    names: tuple[str, ...]
    units: tuple[str, ...]
    start: Array
    reference: Array
    scale: Array
    low: Array
    high: Array

    def bounded(self, values: Array) -> Array:
        """`values` (p,) brought inside the bounds."""
        return np.clip(values, self.low, self.high)

    def at_bound(self, values: Array) -> list[str]:
        """Names of those that `values` has at a bound, to NEAR of their scale."""
        room = np.minimum(values - self.low, self.high - values) / self.scale
        return [name for name, left in zip(self.names, room.tolist(), strict=True) if left < NEAR]

    def slopes(self, function: Callable[[RunSpec], Any], values: Array) -> Array:
        """Slopes (p, ...) of `function` of the run in the parameters at `values` (p,), by central
        differences."""

        def at(values: Array) -> Any:
            return function(self.applied(values))

        steps = np.diag(STEP * self.scale)
        return np.array([(at(values + h) - at(values - h)) / (2 * h.sum()) for h in steps])

    def applied(self, values: Array) -> RunSpec:
        """The run with the fitted parameters set to `values` (p,)."""
        return self.spec.override(dict(zip(self.names, values.tolist(), strict=True)))


def unknowns(spec: RunSpec, names: Sequence[str], dofs: Sequence[str]) -> Unknowns:
    """`names` as unknowns of the platform of `spec`, driven in `dofs`.

    Raises InputError for a name that is no number of the platform, or said twice.
    """
    if not names:
        raise InputError(f'nothing to fit; give --fit {",".join(DEFAULT)}')
    table = {p.name: p for p in spec.declared if _fittable(p)}
    for name in names:
        if name not in table:
            raise InputError(unknown_parameter(name, table))
        if names.count(name) > 1:
            raise InputError(f'{name} is to be fitted twice; name it once')
    platform = Platform.from_spec(spec)
    for dof in dofs:
        if not platform.zeta[DOFS.index(dof)] > 0:
            raise InputError(
                f'{dof} has no damping to start from; give --set platform.zeta=0.02 or so'
            )
    chosen = [table[name] for name in names]
    trim, m = np.array([name == TRIM for name in names]), spec.number('platform.m')
    start = np.array([_start(parameter, spec, platform, dofs[0]) for parameter in chosen])
    reference = np.where(trim, m, start)
    margin = 1e-3 * start  # room for the differences in sensitivity
    least = np.maximum([p.minimum for p in chosen] + margin, start / FARTHEST)
    most = np.minimum([p.maximum for p in chosen] - margin, start * FARTHEST)
    found = Unknowns(
        spec,
        tuple(names),
        tuple(p.unit for p in chosen),
        start,
        reference,
        scale=reference * np.where(trim, TRIM_SHARE, WORTH),
        low=np.where(trim, -0.5 * m, least),
        high=np.where(trim, 2.0 * m, most),
    )
    found.applied(found.start)  # two words for one thing are refused here
    return found


def _fittable(parameter: Parameter) -> bool:
    coupled = any(parameter in law.couples for law in RESTORING.values())
    return parameter.section == 'platform' and parameter.kind is float and not coupled


def _start(parameter: Parameter, spec: RunSpec, platform: Platform, dof: str) -> float:
    """The value that the run has, or what an unset parameter amounts to; 0 only for a trim."""
    start = spec.optional(parameter.name)
    if start is None:
        start = _implied(parameter.name, platform, DOFS.index(dof))
    return start if parameter.name == TRIM else start or 0.01


def _implied(name: str, platform: Platform, dof: int) -> float:
    """What an unset parameter amounts to."""
    design = platform.design
    known: dict[str, float] = {
        'platform.zeta': platform.zeta[dof],
        'platform.A': design.A,
        'platform.k3_hat': design.k3,
        'platform.L1_hat': design.L1,
        'platform.L0_hat': design.L0,
        'platform.I_vm': platform.mass[2],
        'platform.I_hm': platform.mass[3],
        **{f'platform.C.{dof}': c for dof, c in zip(DOFS, platform.damping, strict=True)},
    }
    return known[name]
