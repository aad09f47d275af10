"""What every trace of a plotly document needs: escaped text, hover texts."""

from __future__ import annotations

from html import escape
from typing import Any

Document = dict[str, Any]


def hover(quantity: str, unit: str) -> str:
    """What is said at a point of `quantity`."""
    return f'%{{x:.4g}} Hz<br>{quantity} = %{{y:.4g}}{unit}<extra>%{{fullData.name}}</extra>'


def escaped(text: str) -> str:
    """`text` for plotly's markup, which knows &lt; but not &quot;."""
    return escape(text, quote=False)
