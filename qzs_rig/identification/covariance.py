"""How well a fit knows its parameters: covariance, and which combinations the data fix."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from qzs_rig.identification.fit import Fit
from qzs_rig.identification.unknowns import Unknowns
from qzs_rig.samples import Array

BLIND = 1e-10
"""Of the largest singular value: below, the data say nothing at all about a combination."""


@dataclass(frozen=True)
class Direction:
    """A combination Σ weights (p,) · Δparameter / reference that the data know to `std`, relative;
    the largest weight is 1."""

    weights: Array
    std: float


@dataclass(frozen=True)
class Covariance:
    """Of the parameters, (p, p), with the freedom of its variance and the factor `excess` by which
    given standard deviations were too small, squared."""

    matrix: Array
    directions: tuple[Direction, ...]
    excess: float

    @property
    def std(self) -> Array:
        """Standard errors (p,)."""
        return np.asarray(np.sqrt(np.diag(self.matrix)))

    @property
    def correlation(self) -> Array:
        """Of the estimates (p, p)."""
        return np.asarray(self.matrix / np.outer(self.std, self.std))


def covariance(fit: Fit) -> Covariance:
    """(JᵀJ)⁻¹, or where a parameter fares worse with it the robust HC3 (MacKinnon and White 1985),
    which does not ask all points to be equally noisy.

    Standard deviations that came with the measurement are widened where the fit misses by more.
    """
    scale = fit.unknowns.scale
    J, r = fit.jacobian * scale, fit.residual
    excess = max(1.0, float(r @ r) / max(fit.freedom, 1)) if fit.weighted else 1.0
    U, S, Vt = np.linalg.svd(J, full_matrices=False)
    S = np.maximum(S, BLIND * S[0])
    spread = (U * (r / np.maximum(1.0 - np.sum(U**2, axis=1), 1e-3))[:, None]) / S
    plain = (Vt.T / S**2) @ Vt * excess
    robust = Vt.T @ (spread.T @ spread) @ Vt
    wider = np.sqrt(np.maximum(1.0, np.diag(robust) / np.diag(plain)))
    matrix = plain * np.outer(wider, wider) * np.outer(scale, scale)
    return Covariance(matrix, directions(fit.unknowns, S / np.sqrt(excess), Vt), excess)


def directions(unknowns: Unknowns, S: Array, Vt: Array) -> tuple[Direction, ...]:
    """The right singular vectors Vt (p, p) of the sensitivities per scale, best known first."""
    found = []
    references = np.array([item.reference for item in unknowns.items]) / unknowns.scale
    for s, v in zip(S.tolist(), Vt, strict=True):
        weights = v * references
        largest = weights[np.argmax(np.abs(weights))]
        found.append(Direction(weights / largest, 1.0 / (s * abs(largest))))
    return tuple(found)
