"""One-term harmonic balance of a cubic law: Wang et al. 2022, Eqs (28)-(32).

    w'' + 2 ζ w' + c1 w + c3 w³ = Ĥ Ω² cos Ωτ,   v = Ĥ cos Ωτ,   u = v + w,   w = W cos(Ωτ + φ)

With s = ¾ c3 W², the stiffness the amplitude adds, P = c1 - Ω² and D = 2 ζ Ω, the balance (30)
reads s ((s + P)² + D²) = ¾ c3 (Ĥ Ω²)²; then u/v = (c1 + s + iD) / (c1 + s - Ω² + iD). Written in
s, nothing divides by c3 or Ĥ: the linear law and the vanishing excitation are no special cases.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import ArrayLike, NDArray

from qzs_rig.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SingleTerm:
    """Steady states at `omega` (n,): up to three a frequency, ascending in W, NaN where fewer.

    `W` (n, 3) is the relative amplitude, `T` |u|/|v|, `phase_deg` the phase of u against v in
    (-180, 180], lag negative. `stable` (n, 3) is True where a small disturbance dies out: the
    balance rises with W² (the middle branch falls), and the stiffness averaged over the cycle,
    c1 + 2 s, holds the mean position (a plate with c1 < 0 tips over at small W).
    """

    omega: Array
    W: Array
    T: Array
    phase_deg: Array
    stable: NDArray[np.bool_]


@dataclass(frozen=True)
class Peak:
    """The largest transmissibility on a stable branch."""

    omega: float
    T: float


def single_term(
    c1: float, c3: float, zeta: float, amplitude_hat: ArrayLike, omega: ArrayLike
) -> SingleTerm:
    """Balance at `omega` (n,) > 0 under base amplitude `amplitude_hat`, scalar or (n,) >= 0.

    An undamped resonance without a finite steady state has no branch: its row is NaN.
    Raises InputError for a frequency, amplitude or damping out of these bounds.
    """
    frequency = np.atleast_1d(np.asarray(omega, dtype=np.float64))
    amplitude = np.broadcast_to(np.asarray(amplitude_hat, dtype=np.float64), frequency.shape)
    _check(zeta, amplitude, frequency)
    x = frequency**2
    sign = math.copysign(1.0, c3)
    drive = amplitude * x
    s = sign * _roots(sign * (c1 - x), 2 * zeta * frequency, 0.75 * abs(c3) * drive**2)
    K = c1 + s - x[:, None]
    D = 2 * zeta * frequency[:, None]
    with np.errstate(divide='ignore', invalid='ignore'):
        ratio = (c1 + s + 1j * D) / (K + 1j * D)
        W = drive[:, None] / np.hypot(K, D)
    exists = np.isfinite(ratio) & np.isfinite(W)
    phase_deg = np.degrees(np.angle(ratio))
    slope = K**2 + D**2 + 2 * s * K
    return SingleTerm(
        frequency,
        np.where(exists, W, np.nan),
        np.where(exists, np.abs(ratio), np.nan),
        np.where(exists, np.where(phase_deg > -180, phase_deg, 180.0), np.nan),
        exists & (slope > 0) & (c1 + 2 * s >= 0),
    )


def folds(c1: float, c3: float, zeta: float, amplitude_hat: float, falloff: int = 0) -> Array:
    """Frequencies where two branches meet and a sweep jumps, ascending; empty where none do.

    `amplitude_hat` is the base amplitude at omega = 1, falling as omega^-falloff: 0, 1 and 2 hold
    the base displacement, velocity and acceleration constant. They are the sign changes of the
    discriminant of the balance, a polynomial in x = Ω², to the last few bits.
    """
    _check_held(zeta, amplitude_hat, falloff)

    def discriminant(x: Any) -> Any:
        P, D2 = c1 - x, 4 * zeta**2 * x
        q = 0.75 * c3 * amplitude_hat**2 * x ** (2 - falloff)
        return -4 * (P**2 + D2) ** 2 * D2 - (4 * P**3 + 36 * P * D2) * q - 27 * q**2

    return np.asarray(np.sqrt(_sign_changes(discriminant)))


def onset_omega(
    c1: float, c3: float, zeta: float, amplitude_hat: float, falloff: int = 0
) -> float | None:
    """Highest frequency where T crosses 1 on a stable branch: above it the platform isolates.

    None where no stable branch crosses 1: T stays on one side, or a jump crosses it (see `folds`,
    also for `falloff`). T = 1 means Ω² = 2 (c1 + s), which makes the balance a polynomial in Ω².
    """
    _check_held(zeta, amplitude_hat, falloff)

    def crossing(x: Any) -> Any:
        q = 0.75 * c3 * amplitude_hat**2 * x ** (2 - falloff)
        return (x / 2 - c1) * (x**2 / 4 + 4 * zeta**2 * x) - q

    for omega in np.sqrt(_sign_changes(crossing))[::-1]:
        answer = single_term(c1, c3, zeta, amplitude_hat * omega**-falloff, omega)
        if np.any(answer.stable & (np.abs(answer.T - 1) < 1e-6)):
            return float(omega)
    return None


def peak(c1: float, c3: float, zeta: float, amplitude_hat: float, falloff: int = 0) -> Peak | None:
    """Largest T over all frequencies and stable branches. `falloff`: see `folds`.

    None where there is none: T nowhere exceeds 1, or it grows without bound, undamped or because
    the resonance never meets the backbone (constant displacement, Ĥ >= 2ζ/sqrt(¾ c3)).
    """
    edges = folds(c1, c3, zeta, amplitude_hat, falloff)
    kappa = 0.75 * c3 * amplitude_hat**2
    if zeta == 0 or (falloff == 0 and kappa >= 4 * zeta**2):
        return None
    onset = onset_omega(c1, c3, zeta, amplitude_hat, falloff)
    resonance = _resonance_squared(c1, kappa / (4 * zeta**2), falloff)
    scale = max([math.sqrt(max(resonance, abs(c1))), onset or 0.0, *edges])
    if scale == 0:
        return None

    def highest(omega: Array) -> Array:
        answer = single_term(c1, c3, zeta, amplitude_hat * omega**-falloff, omega)
        return np.asarray(np.max(np.where(answer.stable, answer.T, 0.0), axis=1))

    # The highest T may sit right at a fold: look at both sides of each.
    grid = np.geomspace(1e-4 * scale, 4 * scale, 4000)
    omega = np.sort(np.concatenate([grid, edges * (1 - 1e-12), edges * (1 + 1e-12)]))
    for _ in range(12):
        best = int(np.argmax(highest(omega)))
        around = omega[max(best - 1, 0)], omega[best], omega[min(best + 1, len(omega) - 1)]
        omega = np.unique([np.linspace(*around[:2], 11), np.linspace(*around[1:], 11)])
    heights = highest(omega)
    best = int(np.argmax(heights))
    # Below the grid T tends to 1 from either side: that is no peak.
    return Peak(float(omega[best]), float(heights[best])) if heights[best] > 1 + 1e-6 else None


def _resonance_squared(c1: float, ratio: float, falloff: int) -> float:
    """Ω² where the relative motion lags by 90 degrees: the damped resonance on the backbone
    Ω² = c1 + s, with s = ratio · Ω^(2 - 2 falloff)."""
    if falloff == 0:
        return c1 / (1 - ratio)
    if falloff == 1:
        return c1 + ratio
    return 0.5 * (c1 + math.sqrt(max(c1**2 + 4 * ratio, 0.0)))


def _roots(p: Array, D: Array, q: Array) -> Array:
    """Roots σ >= 0 of σ ((σ + p)² + D²) = q, all (n,), ascending in (n, 3), NaN where fewer."""
    spread = np.sqrt(np.maximum(p**2 - 3 * D**2, 0.0))
    folded = (p < 0) & (spread > 0) & (q > 0)
    hill = np.where(folded, (-2 * p - spread) / 3, 0.0)
    valley = np.where(folded, (-2 * p + spread) / 3, 0.0)
    # Beyond σ = -2p the balance exceeds σ³/4; with p >= 0 it exceeds σ³.
    far = np.maximum(-2 * p, 0.0) + np.cbrt(4 * q)
    starts_low = ~folded | (q <= _balance(hill, p, D))
    three = folded & starts_low & (q >= _balance(valley, p, D))
    low = _between(np.zeros_like(p), np.where(folded, hill, far), p, D, q)
    middle = _between(valley, hill, p, D, q)
    high = _between(valley, far, p, D, q)
    return np.stack(
        [
            np.where(starts_low, low, high),
            np.where(three, middle, np.nan),
            np.where(three, high, np.nan),
        ],
        axis=1,
    )


def _between(under: Array, over: Array, p: Array, D: Array, q: Array) -> Array:
    """Root between `under`, where the balance is too small, and `over`, where it is too large:
    Newton steps, and a halving wherever one would leave the bracket (at a fold the slope is 0). All
    at once, and a small root as exact as a large one: numpy.roots solves one polynomial at a time,
    to the rounding of its largest root."""
    guess = np.where(q > 0, 0.5 * (under + over), 0.0)
    for _ in range(200):
        excess = _balance(guess, p, D) - q
        under = np.where(excess < 0, guess, under)
        over = np.where(excess > 0, guess, over)
        slope = (guess + p) ** 2 + D**2 + 2 * guess * (guess + p)
        with np.errstate(divide='ignore', invalid='ignore'):
            newton = guess - excess / slope
        inside = (newton >= np.minimum(under, over)) & (newton <= np.maximum(under, over))
        following = np.where(inside, newton, 0.5 * (under + over))
        moving = (np.abs(following - guess) > 4e-16 * guess) & (excess != 0)
        if not np.any(moving):
            break
        guess = np.where(moving, following, guess)
    return guess


def _balance(sigma: Array, p: Array, D: Array) -> Array:
    return np.asarray(sigma * ((sigma + p) ** 2 + D**2))


def _sign_changes(function: Callable[[Any], Any]) -> Array:
    """Positive x where `function`, a polynomial also callable on floats, changes sign, ascending.

    The polynomial only says between which turning points to look: its expanded coefficients
    cancel near a resonance, the function as written does not.
    """
    polynomial = function(Polynomial([0.0, 1.0])).trim()
    far = 2 * float(np.max(np.abs(polynomial.roots()), initial=0.0))
    turns = polynomial.deriv().roots().real
    marks = np.unique([1e-12 * far, *turns[(turns > 1e-12 * far) & (turns < far)], far])
    signs = np.sign([function(float(mark)) for mark in marks])
    from scipy.optimize import brentq

    changes = np.flatnonzero(signs[:-1] * signs[1:] < 0)
    smallest = {'xtol': 1e-300, 'rtol': 4 * np.finfo(float).eps}
    return np.array([brentq(function, marks[k], marks[k + 1], **smallest) for k in changes])


def _check(zeta: float, amplitude: Array, omega: Array) -> None:
    for name, values, good, bound in (
        ('zeta', np.atleast_1d(zeta), np.atleast_1d(zeta) >= 0, '0 or more'),
        ('amplitude_hat', amplitude, amplitude >= 0, '0 or more'),
        ('omega', omega, omega > 0, 'above 0'),
    ):
        bad = np.flatnonzero(~(good & np.isfinite(values)))
        if bad.size:
            raise InputError(f'{name} is {values[bad[0]]}; the balance needs a number {bound}')


def _check_held(zeta: float, amplitude_hat: float, falloff: int) -> None:
    _check(zeta, np.array([amplitude_hat]), np.ones(1))
    if falloff not in (0, 1, 2):
        raise InputError(
            f'falloff is {falloff}; give 0 (displacement), 1 (velocity) or 2 (acceleration)'
        )
