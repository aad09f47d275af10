"""A plan followed along known branches, and where it must be stopped."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from qzs_rig import scenario
from qzs_rig.errors import InputError, LimitError
from qzs_rig.excitation.drive import Drive
from qzs_rig.prediction.curve import Branch, Prediction
from qzs_rig.prediction.lookout import GRID_S, follow, look_out
from qzs_rig.run.stages import ExciterStage

STEP_NS = 5_000_000


def branch(name, low, high, *strokes, stable=True):
    f = np.linspace(low, high, 200)
    stroke = np.linspace(*strokes, 200)
    return Branch(name, f, stroke, 0 * f, stroke, np.full(200, stable))


BENT = Prediction(
    'vertical',
    'by hand',
    'none',
    (
        branch('lower', 2.0, 5.0, 0.05, 0.01),
        branch('upper', 1.0, 4.0, 0.1, 0.4),
        branch('middle', 2.0, 4.0, 0.05, 0.4, stable=False),
    ),
    (),
    (),
)
"""A hard spring: forward along the upper branch to 4 Hz, back along the lower one to 2 Hz."""

SWEEP = {
    'run.rate': 200.0,
    'excitation.direction': 'reverse',
    'excitation.frequency_low': 1.0,
    'excitation.frequency_high': 5.0,
    'excitation.duration': 40.0,
    'excitation.ramp': 1.0,
    'excitation.amplitude.vertical': 1.0,
    'run.lead_time': 2.0,
}
ARMED = SWEEP | {'run.predictive_abort': True}


def seen(given, prediction=BENT):
    spec = scenario.of(given)
    return look_out(spec, Drive.from_spec(spec, STEP_NS), (prediction,))


def test_a_sweep_stays_on_its_branch_and_jumps_at_its_end():
    up = np.linspace(1.0, 5.0, 401)
    path = follow(BENT, up)
    names = [BENT.branches[k].name for k in path.branch]
    assert names == ['upper' if f <= 4.0 else 'lower' for f in up]
    np.testing.assert_allclose(path.stroke[up <= 4.0], 0.1 * up[up <= 4.0], rtol=1e-12)
    back = follow(BENT, up[::-1])
    names = [BENT.branches[k].name for k in back.branch]
    assert names == ['lower' if f >= 2.0 else 'upper' for f in up[::-1]]


def test_where_theory_is_silent_the_path_is_too():
    path = follow(BENT, np.array([0.5, 1.5, 4.5, 6.0]))
    assert np.isnan(path.stroke[[0, 3]]).all() and list(path.branch) == [-1, 1, 0, -1]
    assert np.isnan(follow(BENT, np.array([0.5])).stroke).all()
    assert follow(BENT, np.array([3.0])).branch[0] == 0  # from rest: the least stroke


def test_the_run_stops_the_lead_time_before_the_jump():
    foreseen = seen(ARMED | {'run.stroke_limit.vertical': 0.15})
    spec = scenario.of(ARMED)
    drive = Drive.from_spec(spec, STEP_NS)
    at = foreseen.sample * STEP_NS / 1e9 + 2.0
    # the plan is followed every GRID_S, and the sample is rounded down
    assert drive.frequency_hz(at + 0.005) < 2.0 < drive.frequency_hz(at - GRID_S - 0.005)
    assert foreseen.reason.startswith('theory foresees a vertical stroke of 0.1')
    assert foreseen.reason.endswith(
        ' Hz after a jump from the lower branch, beyond run.stroke_limit.vertical = 0.15 m, '
        '2 s ahead'
    )


def test_a_stroke_that_grows_along_its_branch_is_seen_too():
    foreseen = seen(ARMED | {'run.stroke_limit.vertical': 0.03})
    assert 'm on the lower branch at 3.498 Hz' in foreseen.reason
    assert 'after a jump' not in foreseen.reason


def test_rotations_are_told_in_radians():
    turned = {'excitation.amplitude.vertical': 0.0, 'excitation.amplitude.horizontal_rotation': 1.0}
    prediction = Prediction('horizontal_rotation', *list(vars(BENT).values())[1:])
    limit = {'run.stroke_limit.horizontal_rotation': 0.15}
    foreseen = seen(ARMED | turned | limit, prediction)
    assert 'a horizontal rotation stroke of' in foreseen.reason and '0.15 rad' in foreseen.reason


@pytest.mark.parametrize(
    'given', [SWEEP | {'run.stroke_limit.vertical': 0.15}, ARMED | {'run.stroke_limit.vertical': 1}]
)
def test_nothing_is_stopped_without_the_option_or_within_the_limit(given):
    assert seen(given) is None


def test_the_first_of_several_counts():
    both = ARMED | {'excitation.amplitude.horizontal': 1.0, 'run.stroke_limit.vertical': 0.15}
    spec = scenario.of(both | {'run.stroke_limit.horizontal': 0.03})
    sideways = Prediction('horizontal', *list(vars(BENT).values())[1:])
    drive = Drive.from_spec(spec, STEP_NS)
    for predictions in ((BENT, sideways), (sideways, BENT)):
        assert 'a horizontal stroke' in look_out(spec, drive, predictions).reason


def test_a_run_that_would_begin_beyond_the_limit_is_refused():
    with pytest.raises(LimitError, match=r'right after the start; lower excitation\.amplitude'):
        seen(ARMED | {'run.stroke_limit.vertical': 0.005})


def test_where_nothing_is_known_the_run_stops_ahead_of_it():
    holed = replace(BENT, branches=BENT.branches[:1])  # below 2 Hz there is nothing
    foreseen = seen(ARMED | {'run.stroke_limit.vertical': 0.15}, holed)
    assert foreseen.sample == seen(ARMED | {'run.stroke_limit.vertical': 0.15}).sample
    assert foreseen.reason.startswith('theory knows no stable vertical motion at 1.99')


def test_a_limit_without_a_theory_is_refused():
    spec = scenario.of(ARMED | {'run.stroke_limit.vertical': 0.15})
    with pytest.raises(InputError, match='there is no theory of vertical, so its stroke'):
        look_out(spec, Drive.from_spec(spec, STEP_NS), ())


@pytest.mark.parametrize(
    ('given', 'message'),
    [
        ({}, 'has nothing to hold; set run.stroke_limit.vertical'),
        ({'run.stroke_limit.horizontal': 0.1}, 'nothing to hold'),  # horizontal is at rest
        (
            {'run.stroke_limit.vertical': 0.1, 'run.lead_time': 0.5},
            'run.lead_time = 0.5 s is shorter than the ramp down, excitation.ramp = 1 s',
        ),
    ],
)
def test_refuses_what_cannot_work_before_anything_starts(given, message):
    with pytest.raises(InputError, match=message):
        ExciterStage(scenario.of(ARMED | given), STEP_NS)


@pytest.mark.parametrize('chunk', [1, 37, 10**6])
def test_the_ramp_down_begins_at_that_sample_in_any_chunk(chunk):
    spec = scenario.of(ARMED | {'run.stroke_limit.vertical': 0.15})
    whole = ExciterStage(scenario.of(SWEEP), STEP_NS).take(10**6).data
    stage = ExciterStage(spec, STEP_NS)
    stage.start(0, (BENT,))
    sample = seen(ARMED | {'run.stroke_limit.vertical': 0.15}).sample
    pieces = []
    while stage.given < stage.samples:
        # nothing is said before it happens
        assert bool(stage.stopped) == (stage.given > sample)
        pieces.append(stage.take(chunk).data)
    given = np.concatenate(pieces)
    assert stage.samples == len(given) == sample + 201
    assert given[:sample].tobytes() == whole[:sample].tobytes()
    assert np.abs(given[-1]).max() < 1e-12  # at rest: a cosine's zero, to rounding
    assert stage.stopped == seen(ARMED | {'run.stroke_limit.vertical': 0.15}).reason


def test_an_operator_who_is_faster_keeps_his_reason():
    spec = scenario.of(ARMED | {'run.stroke_limit.vertical': 0.15})
    stage = ExciterStage(spec, STEP_NS)
    stage.start(0, (BENT,))
    stage.take(1000)
    stage.stop()
    stage.take(10**6)
    assert (stage.samples, stage.stopped) == (1201, '')
