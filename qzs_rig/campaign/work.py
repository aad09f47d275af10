"""The work on one chunk, in a thread here or in a process of a cluster."""

from __future__ import annotations

import json
from functools import lru_cache

import numpy as np

from qzs_rig.campaign import plan as plans
from qzs_rig.campaign.part import Part
from qzs_rig.campaign.plan import Plan
from qzs_rig.theory.balance.one_thread import one_thread


def evaluate(plan: Plan, number: int) -> Part:
    """The figures of chunk `number`, reduced to the task's outputs."""
    with np.errstate(all='ignore'):  # a failed row is NaN with a reason
        return plan.task.evaluate(plan.between(*plan.part(number)), plan.options)


@one_thread
def evaluate_text(text: str, number: int) -> Part:
    """`evaluate` of the plan that `Plan.text` told: what a worker of a cluster is sent."""
    return evaluate(_read(text), number)


@lru_cache(maxsize=2)
def _read(text: str) -> Plan:
    return plans.of(json.loads(text))
