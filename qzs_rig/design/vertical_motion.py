"""How the vertical motion answers at one level: onset, peak, jumps, by one-term theory."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from qzs_rig.samples import Array
from qzs_rig.theory.oscillator import Oscillator
from qzs_rig.theory.single_term import SingleTerm, folds, onset_omega, peak, single_term

FLAT = 1e-9
"""c1 below which the stiffness at the working point is zero, but for rounding."""
POINTS = 64
LOWEST, HIGHEST = 0.1, 4.0
"""Band over the onset in which relative motion is looked for; at lower frequency the plate rides
along with the base."""


class Response(NamedTuple):
    """Frequencies in Hz, `relative` the largest |u - v| in m over the band around the onset.

    `onset` is the frequency above which T < 1 on every path: the last stable crossing, or the
    jump-down where a sweep falls through 1, but no less than where the settled plate isolates;
    None where the resonance is unbounded. The peak is None where T nowhere exceeds 1 or is
    unbounded.
    """

    onset: float | None
    peak_hz: float | None
    peak_height: float | None
    jump_up: float | None
    jump_down: float | None
    relative: float | None


@dataclass(frozen=True)
class Motion:
    """The vertical motion of an `oscillator`, in one harmonic of its law's odd cubic part."""

    oscillator: Oscillator

    @property
    def settled(self) -> float:
        """Onset at vanishing level, Hz, for c1 = 0: the even term c2 w² lets the plate settle at
        w = -c2/c3 (erratum E20), where its stiffness is c2²/c3; T = 1 at sqrt(2) of that."""
        own = self.oscillator
        (_, c2, _), (c1, c3) = own.law.taylor(own.design)[0], own.cubic
        if own.load or abs(c1) > FLAT or not c3 > 0.0:
            return 0.0
        return own.hertz * math.sqrt(2.0 * c2**2 / c3)

    @cached_property
    def _law(self) -> tuple[float, float, float, float, int]:
        own = self.oscillator
        return *own.cubic, own.zeta, own.amplitude, own.falloff

    @property
    def critical_hat(self) -> float | None:
        """Base amplitude (over length) from which the one-term peak is unbounded: 2 zeta over
        sqrt(3/4 c3). Only a constant displacement has one, on a hardening law."""
        _, c3, zeta, _, falloff = self._law
        return None if falloff or not c3 > 0.0 else 2.0 * zeta / math.sqrt(0.75 * c3)

    @property
    def unbounded(self) -> bool:
        """Whether the level reaches the critical amplitude; undamped, every level does."""
        own, critical = self.oscillator, self.critical_hat
        return own.zeta == 0.0 or (critical is not None and own.amplitude >= critical)

    @cached_property
    def omega_onset(self) -> float | None:
        """Onset over omega0, as `Response.onset`."""
        if self.unbounded:
            return None
        crossing = onset_omega(*self._law) or 0.0
        edges = folds(*self._law)
        if not edges.size:
            return crossing
        below, above = (self._highest(edges * (1.0 + side)) for side in (-1e-9, 1e-9))
        falls = edges[(below >= 1.0) & (above < 1.0)]
        return max(crossing, *falls.tolist()) if falls.size else crossing

    def response(self) -> Response:
        """Onset, peak, jumps and relative motion at this level."""
        onset = self.omega_onset
        if onset is None:
            return Response(None, None, None, None, None, None)
        to_hz = self.oscillator.hertz
        top, edges = peak(*self._law), folds(*self._law) * to_hz
        # a hardening law jumps up at the lower fold and down at the upper one
        up, down = (float(edges[0]), float(edges[-1])) if edges.size > 1 else (None, None)
        return Response(
            max(onset * to_hz, self.settled),
            top.omega * to_hz if top else None,
            top.T if top else None,
            up,
            down,
            self.relative,
        )

    @property
    def relative(self) -> float:
        """Largest stable relative amplitude (m), LOWEST to HIGHEST times the onset; where there is
        none, around the resonance that the level would have."""
        centre = self.omega_onset or 2.0 * self.oscillator.zeta
        omega = np.geomspace(LOWEST * centre, HIGHEST * centre, POINTS)
        edges = folds(*self._law)
        omega = np.concatenate([omega, edges * (1.0 - 1e-9), edges * (1.0 + 1e-9)])
        answer = self._answer(omega)
        return float(np.max(np.where(answer.stable, answer.W, 0.0))) * self.oscillator.length

    def _answer(self, omega: Array) -> SingleTerm:
        return single_term(*self._law[:3], self.oscillator.base(omega), omega)

    def _highest(self, omega: Array) -> Array:
        answer = self._answer(omega)
        return np.asarray(np.max(np.where(answer.stable, answer.T, 0.0), axis=1))
