"""Differences of runs whose differences are known."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from qzs_rig.compare import compare, curve_difference, theory_difference
from qzs_rig.errors import InputError
from qzs_rig.estimation.estimate import Curve, Estimate, Event
from qzs_rig.prediction.curve import Branch, Prediction


def scaled(estimate, factor=1.0, turn=0.0, shift=0.0):
    """`estimate` with T times `factor`, phase plus `turn` degrees, events `shift` Hz up."""
    curves = tuple(
        replace(c, magnitude=c.magnitude * factor, phase_deg=c.phase_deg + turn)
        for c in estimate.curves
    )
    events = tuple(
        replace(e, frequency_hz=e.frequency_hz + shift, magnitude=e.magnitude * factor)
        for e in estimate.events
    )
    return Estimate(curves, events)


def straight(frequency_hz, magnitude=None, direction='forward', dof='vertical'):
    f = np.asarray(frequency_hz, dtype=float)
    T = np.exp(-f) if magnitude is None else np.asarray(magnitude, dtype=float)
    return Curve(dof, direction, 'sine', 'fundamental', f, T, -10 * f, np.full(len(f), np.nan))


def test_a_run_equals_itself(run):
    result = compare([('a', run), ('b', run)])
    assert [(row.rms_percent, row.max_percent, row.max_phase_deg) for row in result.curves] == [
        (0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0),
    ]
    assert {row.difference_hz for row in result.events} == {0.0}
    assert len(result.events) == len(run.events)


def test_known_factor_turn_and_shift(run):
    result = compare([('a', run), ('b', scaled(run, factor=1.1, turn=7.0, shift=0.25))])
    for row in result.curves:
        assert row.rms_percent == pytest.approx(10.0, rel=1e-9)
        assert row.max_percent == pytest.approx(10.0, rel=1e-9)
        assert row.max_phase_deg == pytest.approx(7.0, rel=1e-9)
        assert row.frequency_hz == (0.5, 8.0)
    for event in result.events:
        assert event.difference_hz == pytest.approx(0.25, rel=1e-9)
        assert event.magnitude_percent == pytest.approx(10.0, rel=1e-9)


def test_other_grids_and_order_of_time_do_not_matter():
    """exp(-f) and -10 f are straight in what is interpolated: exact between any points."""
    a = straight(np.linspace(1, 5, 17))
    b = straight(np.geomspace(2, 9, 23)[::-1])
    row = curve_difference('a', a, 'b', b)
    assert row.frequency_hz == (2.0, 5.0)
    assert row.max_percent < 1e-11
    assert row.max_phase_deg < 1e-11


def test_phase_difference_crosses_the_seam():
    f = np.linspace(1, 2, 5)
    one = replace(straight(f), phase_deg=np.full(5, 179.0))
    two = replace(straight(f), phase_deg=np.full(5, -178.0))
    assert curve_difference('a', one, 'b', two).max_phase_deg == pytest.approx(3.0)


def test_unusable_points_are_left_out():
    f = np.linspace(1, 2, 5)
    holed = straight(f, [1.0, np.nan, 1.0, np.inf, 1.0])
    row = curve_difference('a', straight(f, np.ones(5)), 'b', holed)
    assert (row.max_percent, row.points) == (0.0, 5)


def test_ranges_apart_and_empty_curves_say_so():
    a, far = straight([1, 2]), straight([3, 4])
    assert curve_difference('a', a, 'b', far).note == 'no common range: 1-2 Hz and 3-4 Hz'
    assert curve_difference('a', a, 'b', straight([])).note == 'no usable points'


def test_different_quantities_are_marked():
    f = [1.0, 2.0]
    row = curve_difference('a', straight(f), 'b', replace(straight(f), estimator='h1'))
    assert row.note == 'sine fundamental against h1 fundamental'
    assert row.max_percent == 0.0


def test_missing_counterparts_are_shown():
    a = Estimate(
        (straight([1, 2]), straight([1, 2], dof='horizontal')),
        (Event('vertical', 'forward', 'jump_down', 2.0, 3.0, 0.1),),
    )
    b = Estimate(
        (straight([1, 2]), straight([1, 2], direction='reverse')),
        (Event('vertical', 'reverse', 'jump_up', 1.5, 3.0, 0.1),),
    )
    result = compare([('a', a), ('b', b)])
    assert [(r.dof, r.direction, r.note) for r in result.curves] == [
        ('vertical', 'forward', ''),
        ('vertical', 'reverse', 'only in b'),
        ('horizontal', 'forward', 'only in a'),
    ]
    assert [(r.kind, r.a_hz, r.b_hz, r.difference_hz, r.note) for r in result.events] == [
        ('jump_down', 2.0, None, None, 'only in a'),
        ('jump_up', None, 1.5, None, 'only in b'),
    ]
    assert result.to_text().count('only in') == 4


def test_several_events_of_a_kind_pair_by_nearness():
    def jumps(*frequencies):
        return Estimate(
            events=tuple(Event('vertical', 'forward', 'jump_up', f, 1.0, 0.1) for f in frequencies)
        )

    rows = compare([('a', jumps(1.0, 2.0)), ('b', jumps(2.1))]).events
    assert [(row.a_hz, row.b_hz) for row in rows] == [(1.0, None), (2.0, 2.1)]


def test_stepped_run_pairs_with_a_sweep():
    stepped = Estimate((straight([1, 2], direction='none'),))
    swept = Estimate((straight([1, 2]), straight([1, 2], direction='reverse')))
    rows = compare([('stepped', stepped), ('swept', swept)]).curves
    assert [(row.direction, row.note) for row in rows] == [
        ('none/forward', ''),
        ('reverse', 'only in swept'),
    ]


def test_first_is_the_reference_of_all(run):
    rows = compare([('a', run), ('b', run), ('c', run)]).curves
    assert [(row.a, row.b) for row in rows] == [('a', 'b')] * 2 + [('a', 'c')] * 2


def test_document_is_json(run, theory):
    broken = replace(run.curves[0], magnitude=np.full(240, np.nan))
    other = Estimate((broken,), ())
    result = compare([('a', run), ('b', other)], [theory])
    document = json.loads(json.dumps(result.to_document(), allow_nan=False))
    assert document['schema'] == 'qzs_rig/compare/1'
    assert document['items'] == ['a', 'b']
    assert set(document['curves'][0]) >= {
        *('dof', 'direction', 'a', 'b', 'rms_percent', 'max_percent', 'max_phase_deg'),
        'frequency_hz',
    }
    assert set(document['events'][0]) >= {
        *('dof', 'direction', 'kind', 'a_hz', 'b_hz', 'difference_hz'),
    }
    assert len(document['theory'][0]['deviation_percent']) == 240
    assert document['theory'][2]['points'] == 0


def test_labels_must_differ(run):
    with pytest.raises(InputError, match='two items share a label: a, a'):
        compare([('a', run), ('a', run)])


def test_points_on_the_theory_do_not_deviate(run, theory):
    for curve in run.curves:
        row = theory_difference('run', curve, theory)
        assert (row.points, row.unmatched, row.near) == (240, 0, 240)
        # Read off by linear, matched by logarithmic interpolation between 400 points; next to a
        # fold the branch bends hardest.
        assert row.max_percent < 0.2
        assert row.rms_percent < 0.02
        assert row.max_phase_deg < 0.1
        upper = curve.frequency_hz < theory.folds[curve.direction == 'forward'].frequency_hz
        assert row.branch == tuple(np.where(upper, 'upper', 'lower'))


def test_known_deviation_from_theory(theory):
    low = straight(np.linspace(3, 7, 50))
    (branch,) = (branch for branch in theory.branches if branch.name == 'lower')
    exact = np.interp(low.frequency_hz, branch.frequency_hz, branch.transmissibility)
    row = theory_difference('run', replace(low, magnitude=1.05 * exact), theory)
    np.testing.assert_allclose(row.deviation_percent, 5.0, atol=0.03)  # two interpolations
    assert np.isnan(row.z).all()
    stated = replace(low, magnitude=1.05 * exact, uncertainty=0.01 * exact)
    np.testing.assert_allclose(theory_difference('run', stated, theory).z, 5.0, atol=0.03)


def test_unstable_branch_attracts_no_point(theory):
    f = np.array([np.mean([fold.frequency_hz for fold in theory.folds])])
    T = {b.name: np.interp(f, b.frequency_hz, b.transmissibility) for b in theory.branches}
    middle, outer = T['middle'], [T['lower'][0], T['upper'][0]]
    row = theory_difference('run', straight(f, middle), theory)
    assert min(abs(row.theory_magnitude[0] / value - 1) for value in outer) < 1e-3


def test_points_outside_the_theory_are_counted():
    one = np.ones(2)
    line = Branch('only', np.array([1.0, 2.0]), one, 0 * one, one, one.astype(bool))
    theory = Prediction('vertical', 'line', 'by hand', (line,), (), ())
    row = theory_difference('run', straight([0.5, 1.0, 1.5, 2.5], 4 * [1.1]), theory)
    assert (row.points, row.unmatched) == (2, 2)
    assert np.isnan(row.deviation_percent[[0, 3]]).all()
