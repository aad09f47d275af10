"""Differences of angles."""

from __future__ import annotations

import numpy as np

from qzs_rig.samples import Array


def wrapped(degrees: Array) -> Array:
    """The same angles in [-180, 180)."""
    return np.asarray((degrees + 180) % 360 - 180)
