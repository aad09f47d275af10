"""Where motions of the coupled platform gain or lose stability, or fold."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from qzs_rig.theory.balance import continuation
from qzs_rig.theory.balance.continuation import Equations, Point
from qzs_rig.theory.balance.response import Event
from qzs_rig.theory.balance.root import root
from qzs_rig.theory.coupled.balance import CoupledBalance
from qzs_rig.theory.coupled.floquet import multipliers


@dataclass(frozen=True)
class Whole:
    """Unknowns `x` of all six coordinates at `omega`."""

    balance: CoupledBalance
    x: np.ndarray[tuple[int], np.dtype[np.float64]]
    omega: float


@dataclass(frozen=True)
class Pair:
    """Two neighbouring points of a path of `equations`, and what a point of it is as a whole."""

    equations: Equations
    here: Point
    ahead: Point
    whole: Callable[[Point], Whole]

    def between(self, share: float) -> Point | None:
        """The point at `share` of the way."""
        return continuation.between(self.equations, self.here, self.ahead, share)


def fold(pair: Pair, number: int) -> Event | None:
    """Where the path of branch `number` turns back between the two; None where it does not."""

    def turning(share: float) -> float:
        point = pair.between(share)
        return math.nan if point is None else float(point.tangent[-1])

    share = root(turning)
    return None if share is None else _event(pair, share, 'fold', number)


def loss(pair: Pair, number: int) -> Event | None:
    """Where the largest multiplier crosses the unit circle; None where it does not."""

    def excess(share: float) -> float:
        lead = _lead(pair, share)
        return math.nan if lead is None else abs(lead) - 1.0

    share = root(excess)
    lead = None if share is None else _lead(pair, share)
    if share is None or lead is None:
        return None
    kind = 'neimark_sacker'
    if abs(lead.imag) < 1e-4:
        kind = 'period_doubling' if lead.real < 0 else 'symmetry_breaking'
    return _event(pair, share, kind, number)


def _lead(pair: Pair, share: float) -> complex | None:
    point = pair.between(share)
    if point is None:
        return None
    at = pair.whole(point)
    return complex(multipliers(at.balance, at.x, at.omega)[0])


def _event(pair: Pair, share: float, kind: str, number: int) -> Event | None:
    point = pair.between(share)
    if point is None:
        return None
    at = pair.whole(point)
    top = at.balance.seen(at.x)
    u, v = complex(top[1], -top[2]), at.balance.plate.base(at.omega)
    return Event(
        omega=at.omega,
        T=abs(u) / v,
        kind=kind,
        amplitude=abs(u - v),
        phase_deg=float(np.degrees(np.angle(u))),
        branch=number,
        uncertainty=math.nan,
        coefficients=top,
    )
