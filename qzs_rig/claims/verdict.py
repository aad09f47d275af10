"""What a check of a claim says."""

from __future__ import annotations

from typing import NamedTuple

REPRODUCED, NOT_REPRODUCED, CANNOT_TELL = 'reproduced', 'not reproduced', 'cannot tell'


class Verdict(NamedTuple):
    """One claim of the paper, checked; `figures` are numbers this check computed."""

    claim: str
    verdict: str
    figures: dict[str, float]
    how: str


def judged(holds: bool) -> str:
    """The verdict of a check that can tell."""
    return REPRODUCED if holds else NOT_REPRODUCED
