"""The waves in which periodic motions, and small disturbances of them, are expanded.

An odd law lets motions mirror themselves every half period (odd waves only), or come in pairs that
are each other's mirror image.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from qzs_rig.samples import Array
from qzs_rig.theory.oscillator import Oscillator


@dataclass(frozen=True)
class Basis:
    """cos rΩτ and sin rΩτ for each of `orders` r >= 0, ascending; of r = 0 only the constant.

    `samples` are evenly spaced over one period, or over its first half where `half_wave` says that
    every product of two waves repeats twice a period (all orders odd, or all even).
    """

    orders: tuple[float, ...]
    samples: int
    half_wave: bool = False

    @staticmethod
    @cache
    def full(harmonics: int) -> Basis:
        """0, 1, 2, ...: motions of the drive's period. Cubic forces are exact."""
        return Basis(tuple(range(harmonics + 1)), _samples(harmonics))

    @staticmethod
    @cache
    def odd(harmonics: int) -> Basis:
        """1, 3, 5, ...: motions whose second half is the first one mirrored."""
        return Basis(tuple(range(1, harmonics + 1, 2)), _samples(harmonics) // 2, half_wave=True)

    def even(self) -> Basis:
        """0, 2, 4, ...: what breaks the symmetry of motions in this odd basis."""
        return Basis(tuple(range(0, int(self.orders[-1]) + 1, 2)), self.samples, half_wave=True)

    def doubled(self) -> Basis:
        """1/2, 3/2, ...: what doubles the period of motions in this full basis."""
        return Basis(tuple(r + 0.5 for r in range(int(self.orders[-1]))), self.samples)

    @cached_property
    def columns(self) -> NDArray[np.int64]:
        """Places of the waves in the coefficients (mean, cos 1, sin 1, cos 2, ...)."""
        pairs = [(0,) if r == 0 else (int(2 * r) - 1, int(2 * r)) for r in self.orders]
        return np.array([place for pair in pairs for place in pair])

    @cached_property
    def rates(self) -> Array:
        """(coefficients,): the order of each wave."""
        return np.array([r for r in self.orders for _ in range(1 if r == 0 else 2)], dtype=float)

    @cached_property
    def derivative(self) -> Array:
        """(coefficients, coefficients): coefficients to those of the slope in Ωτ."""
        matrix, place = np.zeros((len(self.rates), len(self.rates))), 0
        for r in self.orders:
            if r:
                matrix[place, place + 1], matrix[place + 1, place] = r, -r
            place += 2 if r else 1
        return matrix

    @cached_property
    def to_time(self) -> Array:
        """(samples, coefficients): coefficients to the values at the samples."""
        return self.waves(np.arange(self.samples) / (self.samples * (2 if self.half_wave else 1)))

    @cached_property
    def to_frequency(self) -> Array:
        """(coefficients, samples): values at the samples to coefficients."""
        return np.asarray(np.where(self.rates == 0, 1.0, 2.0)[:, None] * self.to_time.T) / (
            self.samples
        )

    def tangent(self, stiffness: Array) -> Array:
        """(..., coefficients, coefficients): coefficients to those of `stiffness` (..., samples)
        times the wave, what `to_frequency` diag(stiffness) `to_time` is, by its Fourier series."""
        series = np.fft.rfft(stiffness) / self.samples
        means = np.concatenate([series.real, series.imag, -series.real, -series.imag], axis=-1)
        less, more = self._products
        slope = means.take(less, axis=-1)
        slope += means.take(more, axis=-1)
        if self.orders[0] == 0:
            slope[..., 0, :] *= 0.5
        return np.asarray(slope)

    @cached_property
    def _products(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """2 cos i cos j = cos (i-j) + cos (i+j) and its like: where the means of stiffness times
        cos and sin of i-j and of i+j stand, for each pair of waves, in (C, -S, -C, S)."""
        size = self.samples // 2 + 1
        sine = np.concatenate([[0] if r == 0 else [0, 1] for r in self.orders])
        kind, row = sine[:, None] + sine, sine[:, None] == 1
        less, more = self.rates[:, None] - self.rates, self.rates[:, None] + self.rates
        # sin i cos j has sin (i-j), cos i sin j has sin (j-i): of either sign
        first = np.where(kind == 1, np.where(row == (less > 0), 3, 1), 0)
        second = np.choose(kind, [0, 3, 2])
        repeats = 2 if self.half_wave else 1
        order = (np.rint(np.abs(r) / repeats).astype(int) for r in (less, more))
        first, second = (
            size * block + place for block, place in zip((first, second), order, strict=True)
        )
        return first, second

    def waves(self, share: Array) -> Array:
        """(n, coefficients): coefficients to the values at these shares (n,) of a period."""
        angle = 2 * np.pi * np.multiply.outer(share, np.array(self.orders, dtype=float))
        pairs = np.stack([np.cos(angle), np.sin(angle)], axis=-1).reshape(len(share), -1)
        return np.delete(pairs, 1, axis=1) if self.orders[0] == 0 else pairs


def _samples(harmonics: int) -> int:
    # half more than a cubic law needs: of other laws, less comes back as what it is not
    return max(16, 4 * (3 * harmonics // 2 + 1))


def harmonics_of(coefficients: Array) -> int:
    """H of coefficients (..., 2H + 1)."""
    return int(coefficients.shape[-1]) // 2


def resized(coefficients: Array, harmonics: int) -> Array:
    """Coefficients (..., 2H + 1) with more harmonics, which are 0, or fewer: the highest go."""
    whole = np.zeros((*coefficients.shape[:-1], 2 * harmonics + 1))
    kept = min(whole.shape[-1], coefficients.shape[-1])
    whole[..., :kept] = coefficients[..., :kept]
    return whole


def symmetric(oscillator: Oscillator) -> bool:
    """Is the law odd, and nothing loads it off its middle?"""
    return oscillator.dof in oscillator.law.odd and oscillator.load == 0.0


def mirrored(coefficients: Array) -> Array:
    """The motion (2H + 1,) upside down and half a period later: even orders change sign."""
    return coefficients * _signs(len(coefficients))


def even_part(coefficients: Array) -> Array:
    """The even harmonics of a motion (2H + 1,), the others 0."""
    return np.asarray(np.where(_signs(len(coefficients)) < 0, coefficients, 0.0))


def lopsided(coefficients: Array) -> float:
    """What even harmonics are of the whole (2H + 1,)."""
    whole = float(np.linalg.norm(coefficients)) or 1.0
    return float(np.linalg.norm(even_part(coefficients))) / whole


def _signs(size: int) -> Array:
    order = (np.arange(size) + 1) // 2
    return np.where(order % 2 == 0, -1.0, 1.0)
