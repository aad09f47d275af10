"""Theory on the air: told before the run, matched during it, heeded by the exciter."""

from __future__ import annotations

import json

import pytest
from ros_support import SAMPLES, SHORT, Lab, document, given, kept, without_ros

from qzs_rig import scenario, wire
from qzs_rig.cli.run import Recorder, sheet_of
from qzs_rig.prediction.curve import to_document
from qzs_rig.prediction.predict import predict
from qzs_rig.run import in_process

DOWN = SHORT | {
    'excitation.direction': 'reverse',
    'excitation.spacing': 'log',
    'excitation.frequency_low': 1.0,
    'excitation.frequency_high': 3.0,
    'excitation.duration': 20.0,
    'excitation.amplitude.vertical': 4.0,
}
"""Down through the jump up at 1.33 Hz."""
GUARDED = DOWN | {
    'run.predictive_abort': True,
    'run.lead_time': 2.0,
    'run.stroke_limit.vertical': 0.15,
}


@pytest.fixture(scope='module')
def told(tmp_path_factory):
    """A finished run, all that was said on the topics of theory, and its analysis from the bag."""
    with Lab(tmp_path_factory.mktemp('theory')) as lab:
        ears = lab.ears(wire.RUN, wire.THEORY, wire.MATCH)
        assert [node.code() for node in lab.rig(DOWN)] == [0, 0, 0]
        ears.wait('analyzer/match')
        ears.folder = lab.folder
        words = ('analyze', str(lab.folder / 'out'), '--out', str(lab.folder / 'again'))
        again = lab.cli(*words)
        assert again.code() == 0, again.log
        yield ears


def test_branches_are_published_once_and_before_the_run_is_armed(told):
    (message,) = told.messages('theory/branches')
    said = json.loads(message.data)
    run_id = told.sheets()[-1].run_id
    assert said == json.loads(json.dumps(to_document(run_id, predict(scenario.of(DOWN)))))
    # kept for who comes late, and in the folder
    assert document(told.folder / 'out' / 'theory.json') == said


def test_points_are_labelled_live_as_they_are_in_the_folder(told):
    last = json.loads(told.messages('analyzer/match')[-1].data)
    assert last == document(told.folder / 'out' / 'match.json')
    assert last['run_id'] == told.sheets()[-1].run_id
    (row,) = last['curves']
    (curve,) = document(told.folder / 'out' / 'estimate.json')['curves']
    assert len(row['branch']) == len(row['z']) == len(curve['frequency_hz'])
    assert {'lower', 'upper'} >= set(row['branch']) - {'none'}
    assert 'points within 2σ of the lower branch' in row['summary']


@pytest.mark.parametrize('name', ['estimate.json', 'theory.json', 'match.json'])
def test_live_and_from_the_bag_are_the_same_bytes(told, name):
    live, again = (told.folder / where / name for where in ('out', 'again'))
    assert live.read_bytes() == again.read_bytes()


@pytest.mark.parametrize(
    ('mode', 'limit', 'where'),
    [
        ('lockstep', 0.15, 'upper branch at 1.3'),
        ('real_time', 0.0305, 'lower branch at 2.'),  # a few seconds after the start
    ],
)
def test_the_exciter_stops_ahead_of_the_stroke_as_in_process(lab, mode, limit, where):
    guarded = GUARDED | {'run.mode': mode, 'run.stroke_limit.vertical': limit}
    nodes = lab.rig(guarded)
    assert [node.code() for node in nodes] == [1, 1, 1]
    run, estimate = kept(lab.folder / 'out')
    reference, columns = without_ros(guarded)
    expected = in_process.run(scenario.of(guarded))
    assert (run['state'], run['reason']) == ('aborted', expected.stopped)
    assert where in run['reason']
    counts = [topic['received'] for topic in run['topics'].values()]
    assert counts == [expected.samples] * 2 == [len(columns[0])] * 2
    assert estimate == reference
    nodes[0].says(f'{expected.stopped}: ramping down')


def test_a_run_that_begins_beyond_its_limit_is_refused_by_all(lab):
    exciter, *others = lab.rig(GUARDED | {'run.stroke_limit.vertical': 0.001})
    assert exciter.code() == 2
    exciter.says('right after the start; lower excitation.amplitude')
    for node in others:
        node.says('right after the start')
        node.end()
    assert not (lab.folder / 'out').exists()


def test_what_cannot_work_is_refused_before_any_node_starts(lab):
    words = given(GUARDED | {'run.lead_time': 0.5})
    command = lab.cli('rig', *words, '--out', str(lab.folder / 'out'))
    assert command.code() == 2
    assert 'run.lead_time = 0.5 s is shorter than the ramp down' in command.log


def test_a_sheet_of_another_version_is_replayed_without_theory(lab):
    spec = scenario.of(SHORT)
    sheet = sheet_of(spec, SAMPLES, 'old', 'id')
    sheet = sheet.replace(spec={**sheet.spec, 'platform.colour': 'red'})
    recorder = Recorder(lab.folder / 'bag', spec, sheet)
    in_process.run(spec, sheet.start_ns, recorder.keep)
    recorder.close(sheet.replace(state='finished'))
    words = {'bag': str(lab.folder / 'bag'), 'topics': 'imu', 'peers': 'analyzer'}
    player = lab.node('player', words)
    analyzer = lab.node('analyzer', folder=str(lab.folder / 'out'))
    player.says("unknown parameter 'platform.colour'")
    assert (player.code(), analyzer.code()) == (0, 0)
    assert not (lab.folder / 'out' / 'theory.json').exists()


def test_rubbish_on_the_topic_of_theory_disturbs_no_run(lab):
    ears = lab.ears(publishers=(wire.THEORY,))
    analyzer = lab.node('analyzer', folder=str(lab.folder / 'out'))
    for text, complaint in (
        ({'schema': 'other'}, "not a theory: schema is 'other'"),
        ({'schema': 'qzs_rig/theory/1'}, 'damaged theory'),
    ):
        ears.publish['theory/branches'].publish(wire.encode_json(text))
        analyzer.says(f'theory/branches: {complaint}')
    platform, exciter = lab.node('platform'), lab.node('exciter')
    assert [node.code() for node in (exciter, platform, analyzer)] == [0, 0, 0]
    assert (lab.folder / 'out' / 'match.json').is_file()
