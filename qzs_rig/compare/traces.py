"""What every trace of a plotly document needs: escaped text, plain numbers, hover texts."""

from __future__ import annotations

import math
from html import escape
from typing import Any

import numpy as np

from qzs_rig.timehistory import Array

Document = dict[str, Any]


def hover(quantity: str, unit: str) -> str:
    """What is said at a point of `quantity`."""
    return f'%{{x:.4g}} Hz<br>{quantity} = %{{y:.4g}}{unit}<extra>%{{fullData.name}}</extra>'


def escaped(text: str) -> str:
    """`text` for plotly's markup, which knows &lt; but not &quot;."""
    return escape(text, quote=False)


def numbers(values: Array) -> list[float | None]:
    """`values` with null for what is not finite."""
    return [number(value) for value in np.asarray(values, dtype=np.float64)]


def number(value: float) -> float | None:
    """`value`, or null where it is not finite."""
    return float(value) if math.isfinite(value) else None
