"""Names and order of what a report shows."""

from __future__ import annotations

from qzs_rig.estimation.estimate import DIRECTIONS
from qzs_rig.units import DOFS

EVENT_WORDS = {
    'onset': 'isolation onset',
    'peak': 'peak',
    'jump_up': 'jump up',
    'jump_down': 'jump down',
}


def dof_name(dof: str) -> str:
    """'vertical_rotation' as 'vertical rotation'."""
    return dof.replace('_', ' ')


def direction_name(direction: str) -> str:
    """The direction as a label; 'none', of a run that did not sweep, is 'measured'."""
    return 'measured' if direction == 'none' else direction


def event_name(kind: str) -> str:
    """A kind of event as reports name it: 'jump_down' as 'jump down'."""
    return EVENT_WORDS.get(kind, kind.replace('_', ' '))


def dof_order(dof: str) -> tuple[int, str]:
    """Sort key: the rig's order, then whatever else a foreign estimate may name."""
    return (DOFS.index(dof) if dof in DOFS else len(DOFS), dof)


def direction_order(direction: str) -> tuple[int, str]:
    """Sort key: forward, reverse, none, then anything else."""
    known = direction in DIRECTIONS
    return (DIRECTIONS.index(direction) if known else len(DIRECTIONS), direction)
