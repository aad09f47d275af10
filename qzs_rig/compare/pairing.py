"""Which directions of two runs belong together."""

from __future__ import annotations

from qzs_rig.estimation.estimate import Curve, Estimate, Event
from qzs_rig.report.names import dof_order

Direction = str | None
"""None: the run has nothing there."""


def paired_directions(a: Estimate, b: Estimate) -> list[tuple[str, Direction, Direction]]:
    """(dof, direction in a, direction in b) for everything in either; None where one has nothing.

    Equal directions pair; then `none` (stepped or random excitation) pairs with one the other has
    left. Nothing is dropped.
    """
    mine, theirs = _directions(a), _directions(b)
    pairs: list[tuple[str, Direction, Direction]] = []
    for dof in sorted({*mine, *theirs}, key=dof_order):
        left, right = mine.get(dof, []), theirs.get(dof, [])
        pairs += [(dof, direction, direction) for direction in left if direction in right]
        lone_left = [direction for direction in left if direction not in right]
        lone_right = [direction for direction in right if direction not in left]
        if lone_left and lone_right and 'none' in (*lone_left, *lone_right):
            lone_left.sort(key='none'.__ne__)
            lone_right.sort(key='none'.__ne__)
            pairs.append((dof, lone_left.pop(0), lone_right.pop(0)))
        pairs += [(dof, direction, None) for direction in lone_left]
        pairs += [(dof, None, direction) for direction in lone_right]
    return pairs


def joint(a: Direction, b: Direction) -> str:
    """The direction of a row: one word, or both where they differ."""
    return '/'.join(dict.fromkeys(direction for direction in (a, b) if direction))


def _directions(estimate: Estimate) -> dict[str, list[str]]:
    directions: dict[str, list[str]] = {}
    items: tuple[Curve | Event, ...] = (*estimate.curves, *estimate.events)
    for item in items:
        seen = directions.setdefault(item.dof, [])
        if item.direction not in seen:
            seen.append(item.direction)
    return directions
