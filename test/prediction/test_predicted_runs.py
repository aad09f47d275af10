"""Whole runs in process against what was predicted of them."""

from __future__ import annotations

import json

import numpy as np
import pytest

from qzs_rig import scenario
from qzs_rig.cli import main
from qzs_rig.errors import LimitError
from qzs_rig.prediction.labels import label_all
from qzs_rig.prediction.predict import predict
from qzs_rig.run import in_process

DOWN = {
    'run.rate': 200.0,
    'excitation.direction': 'reverse',
    'excitation.spacing': 'log',
    'excitation.duration': 60.0,
    'excitation.amplitude.vertical': 4.0,
}
"""From 4 to 1 Hz through the jump up at 1.33 Hz, after which the plate moves 0.2 m."""
LIMIT = 0.15
GUARDED = DOWN | {'run.predictive_abort': True, 'run.stroke_limit.vertical': LIMIT}


def perform(given, **how):
    """The run's result and the largest vertical distance of top and base from rest, m."""
    strokes = []
    tap = lambda base, out: strokes.append(np.abs(out.top.data[:, 0] - base.data[:, 0]).max())  # noqa: E731
    return in_process.run(scenario.of(given), 0, tap, **how), max(strokes)


def test_a_run_is_stopped_before_the_plate_goes_too_far():
    result, stroke = perform(GUARDED)
    assert stroke < LIMIT
    assert 'on the upper branch at 1.3' in result.stopped
    assert 'after a jump from the lower branch' in result.stopped
    assert '= 0.15 m, 5 s ahead' in result.stopped


def test_a_stroke_that_grows_along_the_upper_branch_is_stopped_too():
    up = GUARDED | {'excitation.direction': 'forward', 'run.stroke_limit.vertical': 0.25}
    result, stroke = perform(up)
    assert 0.2 < stroke < 0.25
    assert 'm on the upper branch at 1.' in result.stopped
    assert perform(up | {'run.predictive_abort': False})[1] > 0.3


def test_without_the_option_it_runs_through_and_goes_too_far():
    for given in (DOWN, GUARDED | {'run.predictive_abort': False}):
        result, stroke = perform(given)
        assert stroke > LIMIT
        assert result.stopped == '' and result.samples == 13201


def test_the_same_sample_and_bits_in_any_chunk():
    whole, _ = perform(GUARDED)
    again, _ = perform(GUARDED, chunk=40, predictions=predict(scenario.of(GUARDED)))
    assert (again.samples, again.stopped) == (whole.samples, whole.stopped)
    assert again.estimate.to_json() == whole.estimate.to_json()


def test_a_run_that_begins_beyond_its_limit_never_moves():
    with pytest.raises(LimitError, match='on the lower branch at 4 Hz'):
        perform(GUARDED | {'run.stroke_limit.vertical': 0.001})


def test_the_points_of_a_quiet_sweep_lie_on_their_branches():
    given = DOWN | {'excitation.direction': 'there_and_back', 'excitation.duration': 240.0}
    spec = scenario.of(given)
    estimate = in_process.run(spec).estimate
    forward, reverse = label_all(estimate, predict(spec))
    # T falls through 1 at a jump, so the higher one is the upper branch
    for found, curve in zip((forward, reverse), estimate.curves, strict=True):
        far = np.abs(np.log(curve.frequency_hz / np.array([[1.3], [2.35]]))).min(axis=0) > 0.1
        names = np.array(found.branch)
        # what rings after a jump is on no branch
        assert set(names[far & (curve.magnitude > 1)]) - {'none'} == {'upper'}
        assert set(names[far & (curve.magnitude < 0.3)]) - {'none'} == {'lower'}
    within, points = (np.sum(list(reverse.counts.values()), axis=0)).tolist()
    assert within / points > 0.9


def test_the_command_tells_of_the_abort_and_keeps_all(tmp_path, capsys):
    words = [word for name, value in GUARDED.items() for word in ('--set', f'{name}={value}')]
    out = tmp_path / 'out'
    code = main.execute(['run', 'vertical_sweep', *words, '--no-bag', '--out', str(out), '--json'])
    document = json.loads(capsys.readouterr().out)
    assert (code, document['state']) == (1, 'aborted')
    assert document['reason'].startswith('theory foresees a vertical stroke of 0.1')
    match = json.loads((out / 'match.json').read_text())
    theory = json.loads((out / 'theory.json').read_text())
    assert match['run_id'] == theory['run_id'] == document['run_id']
    assert match['curves'][0]['summary'].endswith('of the lower branch')
    assert theory['predictions'][0]['folds'][0]['kind'] == 'jump_up'
