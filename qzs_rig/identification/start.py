"""Where the fit begins: the parameters that leave the measured motions least unbalanced.

Put into the balance, a measured motion leaves an error that is smooth in the parameters whether
or not a branch passes there: there is nothing to fall off. Noise biases its minimum a little, so
it only starts the fit of the curves (the equation error of system identification).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from qzs_rig.identification.points import Points
from qzs_rig.identification.response import centred, ratios
from qzs_rig.identification.unknowns import TRIM, Unknowns
from qzs_rig.parameters import RunSpec
from qzs_rig.samples import Array
from qzs_rig.theory.balance.harmonic_balance import HarmonicBalance
from qzs_rig.theory.oscillator import Oscillator

TRIMS = (-0.01, 0.01)
"""Of the payload: a curve is nearly the same for more weight and for less, so both are tried."""

ROUGH = 1e-4
"""Share of the sum of squares at which the search may end."""


def elsewhere(unknowns: Unknowns, values: Array) -> list[Array]:
    """Where else a minimum like `values` (p,) may lie: as much weight too little as there is too
    much, or a good deal either way; nowhere without a fitted trim."""
    if TRIM not in unknowns.names:
        return []
    k, m = unknowns.names.index(TRIM), unknowns.spec.number('platform.m')
    found = []
    for trim in (-values[k], *(share * m for share in TRIMS)):
        found.append(values.copy())
        found[-1][k] = trim
    return found


def idle(unknowns: Unknowns, parts: Sequence[Points]) -> list[str]:
    """Names of the unknowns that do not enter the balance of the measured motions at all."""
    slopes = unknowns.slopes(lambda spec: _errors(spec, parts), unknowns.start)
    return [name for name, slope in zip(unknowns.names, slopes, strict=True) if not slope.any()]


def starts(unknowns: Unknowns, parts: Sequence[Points]) -> list[Array]:
    """Parameters (p,) to fit the curves from, the best balanced first, each but once."""
    from scipy.optimize import least_squares

    scale = unknowns.scale
    bounds = (unknowns.low / scale, unknowns.high / scale)
    found = []
    for begin in (unknowns.start, *elsewhere(unknowns, unknowns.start)[1:]):
        best = least_squares(
            lambda z: _errors(unknowns.applied(z * scale), parts),
            unknowns.bounded(begin) / scale,
            '3-point',
            bounds,
            ftol=ROUGH,
        )
        found.append((best.cost, unknowns.bounded(best.x * scale)))
    kept: list[Array] = []
    for _, values in sorted(found, key=lambda pair: pair[0]):
        if all(np.any(np.abs(values - k) > 0.05 * unknowns.scale) for k in kept):
            kept.append(values)
    return kept


def _errors(spec: RunSpec, parts: Sequence[Points]) -> Array:
    """What one harmonic and the mean leave unbalanced, over the drive and 0.1 + T."""
    errors = []
    for points in parts:
        there = Oscillator.driven(spec, points.dof)
        omega, balance = there.omega(points.frequency_hz), HarmonicBalance(there, 1)
        candidates = []
        motions = [m for ratio in ratios(there, points) for m in centred(there, omega, ratio)]
        for x in motions:
            left = balance.residual(x, omega)[:, 1:]
            weight = there.drive(omega) * (0.1 + points.magnitude)
            candidates.append(left / weight[:, None])
        errors.append(_smaller(candidates).ravel())
    return np.nan_to_num(np.concatenate(errors), nan=1e3, posinf=1e3, neginf=-1e3)


def _smaller(candidates: Sequence[Array]) -> Array:
    """Of each row (n, 2) the candidate that is smaller."""
    size = np.array([np.sum(c**2, axis=1) for c in candidates])
    return np.asarray(np.stack(candidates)[np.argmin(size, axis=0), np.arange(size.shape[1])])
