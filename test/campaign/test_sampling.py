"""Where points lie: grids run through every combination, hypercubes hit every stratum once."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import scipy.stats  # noqa: F401 (loaded before a deadline runs)
from hypothesis import given
from hypothesis import strategies as st

from qzs_rig import scenario
from qzs_rig.campaign.axes import axis_of
from qzs_rig.campaign.sampling import Grid, LatinHypercube, columns
from qzs_rig.errors import InputError

TABLE = {item.name: item for item in scenario.parameters()}


def axis(name, given, grid=True):
    return axis_of(TABLE[name], given, grid)


def cube(points, seed=3, place='centre'):
    axes = (
        axis('platform.k1', {'from': 1.0, 'to': 3.0}, grid=False),
        axis('platform.zeta', {'from': 0.01, 'to': 1.0, 'scale': 'log'}, grid=False),
        axis('platform.law', ['corrected', 'taylor', 'closed_form'], grid=False),
    )
    return LatinHypercube(axes, points, seed, place)


def in_unit(values, low, high, log):
    return np.log(values / low) / np.log(high / low) if log else (values - low) / (high - low)


def test_a_grid_is_the_product_of_its_axes_the_last_fastest():
    given = (
        ('platform.zeta', [0.1, 0.2]),
        ('platform.law', ['taylor', 'corrected']),
        ('platform.substeps', [1, 2, 3]),
    )
    grid = Grid(tuple(axis(*item) for item in given))
    found = columns(grid, 0, grid.points)
    expected = list(itertools.product(*(values for _, values in given)))
    assert list(zip(*(column.tolist() for column in found.values()), strict=True)) == expected


@pytest.mark.parametrize('scale', ['linear', 'log'])
def test_a_range_has_both_ends_and_even_steps(scale):
    values = axis('platform.zeta', {'from': 0.01, 'to': '1e0', 'count': 9, 'scale': scale}).values
    steps = np.diff(np.log(values) if scale == 'log' else values)
    assert (values[0], values[-1]) == (0.01, 1.0)
    assert np.ptp(steps) < 1e-14  # rounding of values up to 1, and of their logarithms up to 4.6


@given(st.integers(1, 400), st.integers(0, 2**31 - 1), st.sampled_from(['centre', 'random']))
def test_every_stratum_of_a_hypercube_is_hit_once(points, seed, place):
    found = columns(cube(points, seed, place), 0, points)
    for name, low, high, log in (('k1', 1.0, 3.0, False), ('zeta', 0.01, 1.0, True)):
        u = in_unit(found[f'platform.{name}'], low, high, log)
        # 1e-9: what exp and log lose, against strata of 1/400
        stratum = np.floor(u * points + (1e-9 if place == 'random' else 0.0))
        assert sorted(stratum.tolist()) == list(range(points))
    shares = np.unique(found['platform.law'], return_counts=True)[1]
    # a third of the strata each, but for the two that lie across a border
    assert points < 3 or shares.max() - shares.min() <= 2


@pytest.mark.parametrize('place', ['centre', 'random', 'maximin'])
def test_any_part_of_a_hypercube_is_that_of_the_whole(place):
    whole = columns(cube(97, place=place), 0, 97)
    for first, stop in ((0, 1), (13, 60), (96, 97)):
        part = columns(cube(97, place=place), first, stop)
        assert all(np.array_equal(part[name], whole[name][first:stop]) for name in whole)


def test_seeds_give_different_hypercubes():
    first, second = (columns(cube(50, seed), 0, 50)['platform.k1'] for seed in (1, 2))
    assert not np.array_equal(first, second)


def test_maximin_keeps_points_apart():
    def closest(place):
        sample = LatinHypercube(cube(40).axes[:2], 40, 3, place)
        unit = [
            in_unit(sample.column(0, 0, 40), 1.0, 3.0, False),
            in_unit(sample.column(1, 0, 40), 0.01, 1.0, True),
        ]
        apart = sum((u[:, None] - u[None, :]) ** 2 for u in unit) + 9.0 * np.eye(40)
        return apart.min()

    assert closest('maximin') > closest('centre')


def test_maximin_is_refused_where_it_would_compare_too_much():
    with pytest.raises(InputError, match=r'maximin compares .* up to 2000 samples; 3000 .* centre'):
        cube(3000, place='maximin')


@pytest.mark.parametrize(
    ('name', 'given', 'words'),
    [
        ('platform.zeta', 0.1, 'is no axis; give a list of values, or .* belongs under base'),
        ('platform.zeta', [], 'the list is empty'),
        ('platform.zeta', [0.1, 1e-1], 'a value is listed twice'),
        ('platform.zeta', [0.1, -1.0], 'platform.zeta = -1.0 is out of range'),
        ('platform.law', ['quintic'], "'quintic' is unknown.*corrected"),
        ('platform.zeta', {'from': 0, 'to': 1}, 'count is missing'),
        (
            'platform.zeta',
            {'from': 0, 'to': 1, 'count': 3, 'step': 1},
            "unknown parameter 'step'",
        ),
        ('platform.zeta', {'from': 0, 'to': 1, 'count': 3, 'scale': 'log'}, 'log scale from 0'),
        (
            'platform.zeta',
            {'from': 0, 'to': 1, 'count': 3, 'scale': 'cubic'},
            "zeta: scale = 'cubic'",
        ),
        ('platform.zeta', {'from': -1, 'to': 1, 'count': 3}, 'out of range'),
        ('platform.zeta', {'from': 0, 'to': 1, 'count': 2.5}, 'zeta: count = 2.5'),
        ('platform.substeps', {'from': 1, 'to': 4, 'count': 4}, 'a range is for real numbers'),
    ],
)
def test_refused_axes(name, given, words):
    with pytest.raises(InputError, match=words):
        axis(name, given)


def test_a_hypercube_counts_samples_not_values():
    with pytest.raises(InputError, match="unknown parameter 'count'"):
        axis('platform.zeta', {'from': 0, 'to': 1, 'count': 3}, grid=False)
