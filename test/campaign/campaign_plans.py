"""Plans that the tests of campaigns share."""

from __future__ import annotations

from typing import Any

from qzs_rig.campaign import plan


def statics(chunk: int | None = 10, vary: dict[str, Any] | None = None, **head: Any) -> plan.Plan:
    """62 points over two axes; at the end of the first axis the springs would not incline."""
    return plan.of(
        {
            'campaign': {'task': 'statics', **({'chunk': chunk} if chunk else {}), **head},
            'base': {'platform.law': 'corrected'},
            'vary': vary
            or {
                'platform.L20': {'from': 0.5, 'to': 0.7, 'count': 31},
                'dof': ['vertical', 'horizontal_rotation'],
            },
        }
    )
