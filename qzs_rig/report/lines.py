"""Branches and phases as lines: where they break, where they are dashed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from qzs_rig.samples import Array

STROKES = {True: 'solid', False: 'dashed'}
"""Of stable and of unstable motions."""


def stretches(stable: NDArray[np.bool_]) -> Iterator[tuple[bool, NDArray[np.bool_]]]:
    """The points (n,) of the stable stretches, then of the unstable ones with the neighbours that
    a line needs to reach the stable ones; each with what it is, and only if there is any."""
    if stable.any():
        yield True, stable
    if not stable.all():
        unstable = ~stable
        yield False, unstable | np.append(unstable[1:], False) | np.append(False, unstable[:-1])


def broken(x: Array, phase_deg: Array) -> tuple[Array, Array]:
    """Both with NaN put in where the phase leaps through ±180 degrees: a leap is no motion."""
    leaps = np.flatnonzero(np.abs(np.diff(phase_deg)) > 180.0) + 1
    return np.insert(x, leaps, np.nan), np.insert(phase_deg, leaps, np.nan)


def joined(pieces: Sequence[tuple[Array, Array]]) -> tuple[Array, Array]:
    """Pieces (x, y) as one line with breaks between them."""
    gap = np.array([np.nan])
    x, y = ([part for piece in pieces for part in (piece[k], gap)][:-1] for k in (0, 1))
    return np.concatenate(x), np.concatenate(y)
