"""The progress bar of long work: on stderr, and only for people."""

from __future__ import annotations

from typing import Any

from tqdm import tqdm


def bar(total: float, unit: str, text: str) -> Any:
    """A bar that shows nothing where stderr is no terminal."""
    return tqdm(
        total=total,
        unit=unit,
        desc=text,
        disable=None,
        leave=False,
        mininterval=0.1,
        bar_format='{desc} {percentage:3.0f}% |{bar}| {n:.1f}/{total:.1f} {unit} '
        '[{elapsed}<{remaining}{postfix}]',
    )
