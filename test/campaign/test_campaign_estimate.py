"""What a campaign is said to take before it starts."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest
from campaign_plans import statics

from qzs_rig.campaign import perform
from qzs_rig.campaign.ledger import opened
from qzs_rig.campaign.plan import Plan
from qzs_rig.campaign.runners import evaluate


def slow(plan: Plan, point_s: float, seen: list[tuple[int, int]]) -> Plan:
    """The plan with a task that takes `point_s` seconds a point."""

    def compute(points, options, harvest):
        seen.append((points.first, points.count))
        time.sleep(point_s * points.count)

    return replace(plan, task=replace(plan.task, compute=compute))


def test_time_is_that_of_points_from_all_over_the_campaign():
    seen = []
    vary = {'platform.A': {'from': 1.0, 'to': 2.0, 'count': 1000}}
    found = perform.expected(slow(statics(chunk=100, vary=vary), 1e-3, seen), 2)
    # a loaded machine sleeps longer, never shorter
    assert 1e-3 <= found.point_s < 5e-3
    firsts = [first for first, _ in seen[-perform.SPOTS :]]
    assert min(firsts) < 100 and max(firsts) > 900
    assert sum(count for _, count in seen[-perform.SPOTS :]) == found.timed <= 100


def test_slow_points_are_timed_once_after_a_first_that_may_compile():
    seen = []
    perform.expected(slow(statics(), 2 * perform.ENOUGH, seen), 2)
    assert [count for _, count in seen] == [1, 1]


def test_memory_counts_the_hypercube_and_chunks_under_way():
    few, many = (perform.expected(slow(statics(), 0.0, []), n).memory for n in (1, 3))
    row = 8 * (2 + len(statics().task.outputs)) + 4
    assert many - few == 2 * 2 * row * 10
    cube = statics(
        sample='latin_hypercube',
        samples=62,
        vary={'platform.A': {'from': 1.0, 'to': 2.0}, 'platform.k3_hat': {'from': 0.1, 'to': 1.0}},
    )
    drawn = perform.expected(slow(cube, 0.0, []), 1).memory - few
    assert drawn == 8 * 62 * (3 * 2 - 1)  # against one column of a grid


def test_a_chunk_holds_what_is_said(tmp_path):
    with opened(tmp_path, statics()) as ledger:
        part = evaluate(statics(), 0)
        ledger.keep(0, part)
        figures = sum(column.nbytes for column in part.columns.values()) + part.code.nbytes
        assert statics().chunk_bytes == figures
        np.testing.assert_array_equal(ledger.column(0, 'stiffness'), part.columns['stiffness'])


@pytest.mark.parametrize('points', [5, 100, 100_000])
def test_small_campaigns_are_cut_finer(points):
    vary = {'platform.A': {'from': 1.0, 'to': 2.0, 'count': points}}
    wanted = statics(chunk=None, vary=vary)
    assert wanted.chunks >= min(points, 15)
    assert wanted.chunk <= wanted.task.chunk
