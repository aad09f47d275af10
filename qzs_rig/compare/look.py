"""Colours and marks shared by the interactive report and the still picture."""

from __future__ import annotations

from dataclasses import dataclass

INK = '#22303c'
QUIET = '#6b7a86'
GRID = '#e6eaed'
UNIT_LINE = '#9aa7b1'

# Okabe and Ito's blue and vermillion families: apart for colour-blind eyes and in grey print.
HUES = {
    'forward': ('#0b62a4', '#56a9dd', '#1b9e8a', '#7b6cc4'),
    'reverse': ('#c2410c', '#f0984f', '#b83280', '#94720b'),
    'none': ('#3f4d58', '#8795a1', '#2f7d4f', '#a0688f'),
}
THEORY_HUES = ('#22303c', '#7a5195', '#2f7d4f', '#94720b')


@dataclass(frozen=True)
class EventMark:
    """The same mark in plotly's and in matplotlib's words, and the character in captions."""

    plotly: str
    matplotlib: str
    character: str


EVENT_MARKS = {
    'onset': EventMark('diamond', 'D', '◆'),
    'peak': EventMark('circle', 'o', '●'),
    'jump_up': EventMark('triangle-up', '^', '▲'),
    'jump_down': EventMark('triangle-down', 'v', '▼'),
}
FOLD_MARKS = {
    'jump_up': EventMark('arrow-up', r'$\uparrow$', '↑'),
    'jump_down': EventMark('arrow-down', r'$\downarrow$', '↓'),
}
OTHER_MARK = EventMark('square', 's', '■')
ARROWS = {
    'forward': EventMark('triangle-right', '>', '▶'),
    'reverse': EventMark('triangle-left', '<', '◀'),
}


def hue(item: int, direction: str) -> str:
    """Colour of run number `item` (0 first) in `direction`."""
    family = HUES.get(direction, HUES['none'])
    return family[item % len(family)]


def line_width(direction: str) -> float:
    """The forward line is broad, so that the reverse one shows on it where they agree."""
    return 3.6 if direction == 'forward' else 1.8


def theory_hue(item: int) -> str:
    """Colour of theory number `item`."""
    return THEORY_HUES[item % len(THEORY_HUES)]


def event_mark(kind: str) -> EventMark:
    """The mark of an event of `kind`."""
    return EVENT_MARKS.get(kind, OTHER_MARK)
