"""One step of a driven, damped oscillator: drifts and kicks of Blanes and Moan's SRKN11.

S. Blanes, P. C. Moan, J. Comput. Appl. Math. 142 (2002) 313, method SRKN_11^b: order 6 for w'' =
f(w, τ), eleven forces a step. Damping goes into the drift, where it is exact: w'' = -2 ζ w' leaves
w' e^(-2ζs) and w + w' (1 - e^(-2ζs))/(2ζ) after s. The conditions of order rest on kicks that
commute with their own commutators, which this drift, linear in w', does not disturb.
"""

from __future__ import annotations

from typing import NamedTuple

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


class Schedule(NamedTuple):
    """Kicks of `steps` steps: `weights` (11 steps + 1,), `cosines` (11 steps + 1,) of the base's
    phase then, `wave` (steps, 2) its cosine and sine at the step ends; `step` is the length of a
    step in phase. The same for every frequency."""

    weights: Array
    cosines: Array
    wave: Array
    step: float


def schedule(steps: int, phase: float = 0.0) -> Schedule:
    """A period of `steps` that begins at the base's `phase`."""
    when = np.concatenate([[0.0], np.cumsum(np.tile(DRIFTS, steps))]) / steps
    turned = 2.0 * np.pi * np.arange(1, steps + 1) / steps + phase
    return Schedule(
        kick_weights(steps),
        np.cos(2.0 * np.pi * when + phase),
        np.stack([np.cos(turned), np.sin(turned)], axis=-1),
        2.0 * np.pi / steps,
    )


def single_steps(whole: Schedule) -> list[Schedule]:
    """The steps of a schedule one by one: each ends with a kick of its own, so that the velocity
    stands at the same time as w."""
    weights = kick_weights(1)
    return [
        Schedule(
            weights, whole.cosines[STAGES * k :][: STAGES + 1], whole.wave[k : k + 1], whole.step
        )
        for k in range(len(whole.wave))
    ]
