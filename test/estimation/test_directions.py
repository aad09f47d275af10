"""Laws of the directions: turns are found through scatter, holds are no sweep."""

import itertools

import numpy as np
import pytest

from qzs_rig.estimation.track import monotone_runs, sweep_runs


def triangle(points, turns):
    knots = np.linspace(0, points - 1, turns + 2)
    return np.interp(np.arange(points), knots, np.arange(turns + 2) % 2 * 3.0 + 1.0)


@pytest.mark.parametrize('turns', [0, 1, 2, 3])
@pytest.mark.parametrize('scatter', [0.0, 0.002, 0.02])
def test_runs_alternate_and_turn_where_the_frequency_does(turns, scatter):
    frequency = triangle(400, turns)
    frequency = frequency + scatter * np.random.default_rng(turns).standard_normal(400)
    runs = sweep_runs(frequency)
    assert [run.direction for run in runs] == (['forward', 'reverse'] * 2)[: turns + 1]
    reach = 2 + 8 * scatter / (3.0 * (turns + 1) / 400)
    for run, (first, last) in zip(runs, _legs(400, turns), strict=True):
        assert abs(run.first - first) <= reach
        assert abs(run.last - last) <= reach


def _legs(points, turns):
    knots = np.linspace(0, points, turns + 2)
    return list(itertools.pairwise(knots))


def test_holds_at_the_ends_are_left_out():
    up = np.linspace(1.0, 4.0, 100)
    frequency = np.concatenate([np.full(50, 1.0), up, np.full(40, 4.0), up[::-1], np.full(30, 1.0)])
    forward, reverse = sweep_runs(frequency)
    assert (forward.direction, reverse.direction) == ('forward', 'reverse')
    assert forward.last - forward.first == pytest.approx(100, abs=3)
    assert reverse.last - reverse.first == pytest.approx(100, abs=3)


def test_a_dwell_is_one_run_without_direction():
    frequency = 2.0 + 0.002 * np.random.default_rng(0).standard_normal(100)
    assert sweep_runs(frequency) == [(0, 100, 'none')]
    assert sweep_runs(np.array([2.0])) == [(0, 1, 'none')]
    assert sweep_runs(np.empty(0)) == []


def test_steps_turn_at_the_last_step_of_a_direction():
    runs = monotone_runs(np.array([1.0, 2.0, 3.0, 2.5, 1.5]), 0.0)
    assert runs == [(0, 3, 'forward'), (3, 5, 'reverse')]
    assert monotone_runs(np.array([2.0]), 0.0) == [(0, 1, 'none')]
    assert monotone_runs(np.empty(0), 0.0) == []
