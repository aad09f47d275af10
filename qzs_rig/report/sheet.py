"""What a figure shows, as data; `still` and `interactive` draw it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from qzs_rig.samples import Array

INK = '#22303c'
QUIET = '#6b7a86'
GRID = '#e6eaed'
RULE = '#9aa7b1'
PALE = '#a9cbe6'
GREY = '#8795a1'
HUES = ('#0b62a4', '#c2410c', '#1b9e8a', '#7b6cc4', '#94720b', '#b83280', '#2f7d4f', '#3f4d58')
"""Of curves side by side. Blue and vermilion first (Okabe and Ito): apart for colour-blind eyes and
in grey print."""


class Mark(NamedTuple):
    """One mark by Bokeh's name and its turn in degrees, by matplotlib's, and as a character."""

    bokeh: str
    turn: float
    matplotlib: str
    character: str


MARKS = {
    'dot': Mark('circle', 0.0, 'o', '●'),
    'square': Mark('square', 0.0, 's', '■'),
    'diamond': Mark('square', 45.0, 'D', '◆'),
    'up': Mark('triangle', 0.0, '^', '▲'),
    'down': Mark('inverted_triangle', 0.0, 'v', '▼'),
    'right': Mark('triangle', -90.0, '>', '▶'),
    'left': Mark('triangle', 90.0, '<', '◀'),
    'arrow_up': Mark('triangle', 0.0, r'$\uparrow$', '↑'),
    'arrow_down': Mark('inverted_triangle', 0.0, r'$\downarrow$', '↓'),
}

STROKES = ('solid', 'dashed', 'dotted')
STROKE_OF = {True: 'solid', False: 'dashed'}
"""Of stable and of unstable motions."""


@dataclass(frozen=True)
class Curve:
    """A line through (n,) points, broken at NaN; `stroke` is one of STROKES.

    What has one label in a sheet is one entry of its key, and is hidden together; what has none
    is not in the key. `notes` are said beside the numbers of each point.
    """

    label: str
    x: Array
    y: Array
    colour: str = HUES[0]
    stroke: str = 'solid'
    width: float = 1.8
    notes: Sequence[str] = ()


@dataclass(frozen=True)
class Points:
    """Marks at (n,) points; `size` is a diameter in points of print. Label and notes as of a
    `Curve`."""

    label: str
    x: Array
    y: Array
    colour: str = HUES[0]
    mark: str = 'dot'
    size: float = 4.5
    hollow: bool = False
    notes: Sequence[str] = ()


@dataclass(frozen=True)
class Band:
    """The area between `low` and `high` (n,): an interval at each x. Label as of a `Curve`."""

    label: str
    x: Array
    low: Array
    high: Array
    colour: str = HUES[0]


@dataclass(frozen=True)
class Regions:
    """Whole numbers (n_y, n_x) over evenly spaced x and y, a name and a colour for each number."""

    x: Array
    y: Array
    which: NDArray[np.int64]
    names: Mapping[int, tuple[str, str]]


@dataclass(frozen=True)
class Shades:
    """Values as colours, with a scale beside: (n_y, n_x) over rising x (n_x,) and y (n_y,), or (n,)
    dots at x (n,) and y (n,)."""

    x: Array
    y: Array
    values: Array


Item = Curve | Points | Band | Regions | Shades


@dataclass(frozen=True)
class Panel:
    """One pair of axes and what is in it, drawn in order.

    `log` names the logarithmic axes: '', 'x', 'y' or 'xy'. `level` is a dotted line across.
    Ranges are the first view, None for all there is. `y_step` is the distance of ticks and
    `height` the share of a column that the panel takes.
    """

    title: str
    x_label: str
    y_label: str
    items: tuple[Item, ...]
    log: str = ''
    level: float | None = None
    x_range: tuple[float, float] | None = None
    y_range: tuple[float, float] | None = None
    y_step: float | None = None
    height: float = 1.0

    def span(self, axis: str) -> tuple[float, float]:
        """First view of `axis`, x or y: its range, or all there is, in y with room about it."""
        given = self.x_range if axis == 'x' else self.y_range
        if given is not None:
            return given
        there = np.concatenate([np.ravel(v) for item in self.items for v in _values(item, axis)])
        if axis in self.log:
            there = np.log(there[there > 0.0])
        there = there[np.isfinite(there)]
        low, high = (float(there.min()), float(there.max())) if there.size else (0.0, 1.0)
        room = (0.06 if axis == 'y' else 0.0) * (high - low) if low < high else 0.5
        low, high = low - room, high + room
        return (math.exp(low), math.exp(high)) if axis in self.log else (low, high)


@dataclass(frozen=True)
class Sheet:
    """One figure; panels row by row. With `linked`, the panels of a column share their x axis and
    the key of the uppermost. `name` is that of its files and of its place in a page."""

    name: str
    title: str
    caption: str
    panels: tuple[Panel, ...]
    columns: int = 1
    linked: bool = False
    lines: tuple[str, ...] = ()
    marks: tuple[tuple[str, str], ...] = ()
    """`lines` are further sentences of the page, `marks` name marks (of MARKS) below it."""

    @property
    def one_key(self) -> bool:
        """Do all panels name the same lines?"""
        return self.linked or len({tuple(key(panel)) for panel in self.panels}) == 1


def _values(item: Item, axis: str) -> tuple[Array, ...]:
    if isinstance(item, Band) and axis == 'y':
        return item.low, item.high
    values: Array = getattr(item, axis)
    return (values,)


def hue(number: int) -> str:
    """Colour of curve `number`, 0 first."""
    return HUES[number % len(HUES)]


class Entry(NamedTuple):
    """What the key shows of a label."""

    label: str
    colour: str
    character: str = ''
    stroke: str = ''
    """A character, or the stroke of a line."""


def key(*panels: Panel) -> list[Entry]:
    """The labels of `panels`, each once, by the first thing that carries it."""
    found: dict[str, Entry] = {}
    for item in chain.from_iterable(panel.items for panel in panels):
        for entry in _entries(item):
            if entry.label:
                found.setdefault(entry.label, entry)
    return list(found.values())


def _entries(item: Item) -> Iterator[Entry]:
    if isinstance(item, Regions):
        for name, colour in item.names.values():
            yield Entry(name, colour, '■')
    elif isinstance(item, Points):
        yield Entry(item.label, item.colour, MARKS[item.mark].character)
    elif isinstance(item, Band):
        yield Entry(item.label, item.colour, '▒')
    elif isinstance(item, Curve):
        yield Entry(item.label, item.colour, stroke=item.stroke)


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
