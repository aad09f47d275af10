"""One step of a driven, damped oscillator: drifts and kicks of Blanes and Moan's SRKN11.

S. Blanes, P. C. Moan, J. Comput. Appl. Math. 142 (2002) 313, method SRKN_11^b: order 6 for w'' =
f(w, τ), eleven forces a step. Damping goes into the drift, where it is exact: w'' = -2 ζ w' leaves
w' e^(-2ζs) and w + w' (1 - e^(-2ζs))/(2ζ) after s. The conditions of order rest on kicks that
commute with their own commutators, which this drift, linear in w', does not disturb.
"""

from __future__ import annotations

import numpy as np

from qzs_rig.samples import Array

ORDER = 6

_B = (
    0.0414649985182624,
    0.198128671918067,
    -0.0400061921041533,
    0.0752539843015807,
    -0.0115113874206879,
)
_A = (
    0.123229775946271,
    0.290553797799558,
    -0.127049212625417,
    -0.246331761062075,
    0.357208872795928,
)

DRIFTS = np.array([*_A, 1.0 - 2.0 * sum(_A), *_A[::-1]])
"""(11,) lengths of the drifts over the step."""

KICKS = np.array([*_B, 0.5 - sum(_B), 0.5 - sum(_B), *_B[::-1]])
"""(12,) weights of the kicks: one before each drift and one after the last, which the first of
the next step joins."""

STAGES = len(DRIFTS)


def kick_weights(steps: int) -> Array:
    """(11 steps + 1,) weights of all kicks of a period of `steps`, those between steps joined."""
    inner = np.tile(np.append(KICKS[1:-1], 2.0 * KICKS[0]), steps)
    inner[-1] = KICKS[0]
    return np.append(KICKS[0], inner)


def kick_cosines(steps: int, phase: float = 0.0) -> Array:
    """(11 steps + 1,) cos(Ωτ + phase) at those kicks, the same for every frequency."""
    when = np.concatenate([[0.0], np.cumsum(np.tile(DRIFTS, steps))]) / steps
    return np.asarray(np.cos(2.0 * np.pi * when + phase))
