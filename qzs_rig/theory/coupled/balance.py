"""Harmonic balance of the coupled platform's six coordinates."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from qzs_rig.samples import Array
from qzs_rig.theory.balance.basis import Basis
from qzs_rig.theory.coupled.plant import COORDINATES, Plate


@dataclass(frozen=True)
class CoupledBalance:
    """Unknowns are the coefficients (6, 2H + 1) of the coordinates, flat; over ln Ω."""

    plate: Plate
    harmonics: int

    @property
    def basis(self) -> Basis:
        """The waves of every coordinate."""
        return Basis.full(self.harmonics)

    @property
    def angle(self) -> Array:
        """(samples,): phases of the base at which forces are taken."""
        return 2 * np.pi * np.arange(self.basis.samples) / self.basis.samples

    def motion(self, x: Array, omega: float, angle: Array) -> tuple[Array, Array, Array]:
        """Coordinates, velocities and accelerations, each (6, n), at n phases."""
        waves = self.basis.waves(angle / (2 * np.pi))
        own = x.reshape(COORDINATES, -1)
        speed = omega * own @ self.basis.derivative.T
        pull = -((omega * self.basis.rates) ** 2) * own
        return own @ waves.T, speed @ waves.T, pull @ waves.T

    def residual(self, x: Array, omega: float) -> Array:
        """(6 (2H + 1),)."""
        found = self.plate.residual(*self.motion(x, omega, self.angle), omega, self.angle)
        return np.asarray(found @ self.basis.to_frequency.T).ravel()

    def linearised(self, x: Array, p: float) -> tuple[Array, Array, Array]:
        """See continuation.Equations."""
        omega, basis = math.exp(min(p, 50.0)), self.basis
        motion = self.motion(x, omega, self.angle)
        place, speed, pull = basis.tangent(self.plate.slopes(*motion, omega, self.angle))
        blocks = place + omega * speed @ basis.derivative - pull * (omega * basis.rates) ** 2
        size = COORDINATES * len(basis.rates)
        jacobian = np.moveaxis(blocks, 2, 1).reshape(size, size)
        # only Newton's pace and the tangent hang on it
        ahead, behind = (self.residual(x, omega * math.exp(side)) for side in (1e-5, -1e-5))
        return self.residual(x, omega), jacobian, (ahead - behind) / 2e-5

    def resting(self) -> Array:
        """The unknowns of a plate at rest in space."""
        x = np.zeros((COORDINATES, len(self.basis.rates)))
        x[:, 0] = self.plate.rest
        return x.ravel()

    def resized(self, x: Array) -> Array:
        """Unknowns of another number of harmonics as this one's."""
        own = x.reshape(COORDINATES, -1)
        n = len(self.basis.rates)
        kept = own[:, :n]
        return np.pad(kept, ((0, 0), (0, n - kept.shape[1]))).ravel()

    def tail(self, x: Array) -> float:
        """The last two harmonics over all that moves."""
        own = x.reshape(COORDINATES, -1)[:, 1:]
        return float(np.linalg.norm(own[:, -4:]) / (np.linalg.norm(own) or 1.0))

    def seen(self, x: Array) -> Array:
        """(2H + 1,): coefficients of the plate's own motion along the driven degree of freedom."""
        own = x.reshape(COORDINATES, -1) @ self.basis.to_time.T
        return np.asarray(self.basis.to_frequency @ self.plate.seen(own))
