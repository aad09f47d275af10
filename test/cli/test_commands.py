"""`qzs-rig` as a user runs it: what is printed where, exit codes, files, nothing overwritten."""

from __future__ import annotations

import json
import shutil
import signal

import pytest
from ros_support import SAMPLES, SHORT, Lab, document, given, kept, read, wait_until

from qzs_rig.bag import info

FIELDS = {'schema', 'run_id', 'mode', 'rig_s', 'wall_s', 'topics', 'bag', 'estimate', 'report'}
COMMANDS = ('rig', 'run', 'analyze', 'replay', 'compare', 'scenarios', 'bag info', 'bag recover')


@pytest.fixture(scope='module')
def runs(tmp_path_factory):
    """One run by the nodes and the same in process, as the two commands printed them."""
    with Lab(tmp_path_factory.mktemp('runs')) as lab:
        out = {verb: lab.folder / verb for verb in ('rig', 'run')}
        commands = {
            verb: lab.cli(
                verb, 'vertical_sweep', *given(SHORT), '--out', str(out[verb]), '--json'
            )
            for verb in out
        }  # fmt: skip
        assert [command.code() for command in commands.values()] == [0, 0]
        yield {verb: (out[verb], commands[verb]) for verb in out}


@pytest.mark.parametrize('verb', ['rig', 'run'])
def test_json_of_a_run(runs, verb):
    out, command = runs[verb]
    said = json.loads(command.out)  # one document and nothing else
    assert set(said) >= FIELDS
    assert said['schema'] == 'qzs_rig/run/1'
    assert said['mode'] == {'rig': 'lockstep', 'run': 'in_process'}[verb]
    assert said['rig_s'] == 10.0 and said['wall_s'] > 0
    counts = {'published': SAMPLES, 'received': SAMPLES, 'lost': 0, 'duplicated': 0}
    assert said['topics'] == {'base/imu': counts, 'top/imu': counts}
    assert {p.name for p in out.iterdir()} >= {'run.json', 'estimate.json', 'report.html'}
    assert document(out / 'run.json').items() >= {k: said[k] for k in ('run_id', 'topics')}.items()
    assert info(out).lossless


def test_nodes_and_one_process_agree(runs):
    assert kept(runs['rig'][0])[1] == kept(runs['run'][0])[1]


def test_help(lab):
    commands = {verb: lab.cli(*verb.split(), '--help') for verb in COMMANDS}
    top = lab.cli('--help')
    for verb, command in commands.items():
        assert command.code() == 0
        assert command.out.startswith(f'usage: qzs-rig {verb}')
    assert top.code() == 0
    for verb in COMMANDS:
        assert verb.split()[0] in top.out
    assert 'exit codes: 0 ok, 1 aborted or a finding, 2 bad input, 3 samples were lost' in top.out


def test_what_is_kept_can_be_looked_at(lab, runs):
    """analyze, compare, bag info, scenarios: text without --json, one document with it."""
    rig, run = str(runs['rig'][0]), str(runs['run'][0])
    words = {
        'analyze': ('analyze', rig),
        'compare': ('compare', rig, run, '--report', str(lab.folder / 'a.html')),
        'info': ('bag', 'info', rig),
        'scenarios': ('scenarios',),
        'parameters': ('scenarios', '--parameters'),
    }
    plain = {name: lab.cli(*each) for name, each in words.items()}
    words['compare'] = ('compare', rig, run, '--report', str(lab.folder / 'b.html'))
    as_json = {name: lab.cli(*each, '--json') for name, each in words.items()}
    for name in words:
        assert plain[name].code() == as_json[name].code() == 0, plain[name].log + as_json[name].log
    assert json.loads(as_json['analyze'].out) == kept(runs['rig'][0])[1]
    assert 'onset' in plain['analyze'].out
    assert 'schema' in json.loads(as_json['compare'].out)
    assert (lab.folder / 'a.html').is_file() and (lab.folder / 'b.html').is_file()
    assert json.loads(as_json['info'].out)['lossless'] is True
    assert '/base/imu' in plain['info'].out
    assert 'vertical_sweep' in json.loads(as_json['scenarios'].out)['scenarios']
    names = {p['name'] for p in json.loads(as_json['parameters'].out)['parameters']}
    assert {'run.rate', 'platform.k1', 'analyzer.periods'} <= names
    assert 'run.rate = 500.0 Hz' in plain['parameters'].out


def test_text_and_folder_of_its_own(lab):
    """Without --out a run keeps itself below runs/; without --json it prints a table."""
    work = lab.folder / 'work'
    work.mkdir()
    scenario = lab.folder / 'mine.yaml'
    body = json.dumps(SHORT | {'platform.zeta': 0.08})
    scenario.write_text(f'/**:\n  ros__parameters: {body}\n')
    command = lab.cli('run', str(scenario), cwd=work)
    assert command.code() == 0, command.log
    (folder,) = (work / 'runs').iterdir()
    assert '_mine_' in folder.name
    assert 'onset' in command.out and '0 lost' in command.out and str(folder.name) in command.out
    assert read(folder)[0][-1].spec['platform.zeta'] == 0.08


REFUSED = {
    'unknown scenario': (('run', 'vertical_swep'), 'known: coupled_sweep'),
    'misspelt name': (('run', '--set', 'platform.zetta=1'), "did you mean 'platform.zeta'?"),
    'no assignment': (('run', '--set', 'platform.zeta'), 'is not an assignment'),
    'out of range': (('rig', '--set', 'run.rate=0'), 'run.rate = 0 is out of range'),
    'wrong source': (('rig', '--set', 'analyzer.source=driver'), 'run the analyzer node alone'),
    'shaker': (('rig', 'paper_test'), 'the shaker cannot do this run'),
    'shaker in process': (('run', 'paper_test'), '0.5 Hz is below its 1 Hz'),
    'no bag': (('analyze', 'nowhere'), 'nowhere'),
    'a text': (('analyze', 'note.txt'), 'note.txt'),
    'not MCAP': (('bag', 'info', 'note.mcap'), 'note.mcap'),
    'nothing to save': (('bag', 'recover', 'note.mcap'), 'does not begin like an MCAP file'),
    'cut off': (('analyze', 'cut.mcap'), 'qzs-rig bag recover'),
    'cut off, replayed': (('replay', 'cut.mcap'), 'qzs-rig bag recover'),
    'other topics': (('analyze', 'RUN', '--set', 'analyzer.base.topic=/imu'), '/imu'),
    'nonsense': (('compare', 'nonsense.json', 'nonsense.json'), 'not an estimate'),
    'occupied by a run': (('run', '--out', 'RUN'), 'nothing is overwritten'),
    'occupied by nodes': (('rig', '--out', 'RUN'), 'nothing is overwritten'),
    'occupied by an analysis': (('analyze', 'RUN', '--out', 'RUN'), 'nothing is overwritten'),
    'occupied by a copy': (
        ('bag', 'recover', 'RUN', '--out', 'RUN'),
        'is not empty; choose a new one',
    ),
    'occupied page': (('compare', 'RUN', '--report', 'note.txt'), 'is already there'),
}


def test_refusals(lab, runs):
    """One line that names the thing and the way out, exit code 2, nothing on stdout."""
    work = lab.folder / 'work'
    work.mkdir()
    run = runs['run'][0]
    (work / 'note.txt').write_text('mine')
    (work / 'note.mcap').write_text('mine')
    (work / 'nonsense.json').write_text('{"schema": "something else"}')
    whole = next(run.glob('*.mcap')).read_bytes()
    (work / 'cut.mcap').write_bytes(whole[: len(whole) // 2])
    before = {p: p.stat().st_mtime_ns for p in run.rglob('*')}
    names = list(REFUSED)
    for batch in range(0, len(names), 5):  # five at a time are enough for two cores
        commands = {
            name: lab.cli(*(str(run) if w == 'RUN' else w for w in REFUSED[name][0]), cwd=work)
            for name in names[batch : batch + 5]
        }
        for name, command in commands.items():
            assert command.code() == 2, (name, command.log, command.out)
            last = command.log.strip().splitlines()[-1]
            assert last.startswith('qzs-rig: ') and REFUSED[name][1] in last, (name, command.log)
            assert 'Traceback' not in command.log and command.out == '', name
    assert (work / 'note.txt').read_text() == 'mine'
    assert {p: p.stat().st_mtime_ns for p in run.rglob('*')} == before
    assert not (work / 'runs').exists()


def test_recover_a_bag_that_was_cut_off(lab, runs):
    whole = next(runs['run'][0].glob('*.mcap')).read_bytes()
    cut = lab.folder / 'cut.mcap'
    cut.write_bytes(whole[: len(whole) * 2 // 3])
    saved = lab.folder / 'saved'
    recover = lab.cli('bag', 'recover', str(cut), '--out', str(saved), '--json')
    assert recover.code() == 0, recover.log
    report = json.loads(recover.out)
    assert report['was_closed'] is False and report['messages']['/base/imu'] > 100
    assert len(cut.read_bytes()) == len(whole) * 2 // 3
    analyze = lab.cli('analyze', str(saved), '--json')
    assert analyze.code() == 0, analyze.log
    assert json.loads(analyze.out)['schema'] == 'qzs_rig/estimate/1'


def test_samples_that_are_missing_are_a_finding(lab, runs):
    """bag info ends with 3 where the index of the stamps shows a gap."""
    from qzs_rig import wire
    from qzs_rig.bag import BagReader, BagWriter, TopicSpec

    reader = BagReader(runs['run'][0])
    rows = reader.rows('base/imu', wire.BASE_IMU.type)
    stamps, messages = rows.stamps_ns, rows.messages()
    reader.close()
    writer = BagWriter(lab.folder / 'gap', [TopicSpec('base/imu', wire.BASE_IMU.type, 10)])
    for part in (slice(0, 500), slice(507, None)):
        writer.write('base/imu', stamps[part], messages[part])
    writer.close()
    command = lab.cli('bag', 'info', str(lab.folder / 'gap'), '--json')
    assert command.code() == 3
    (topic,) = json.loads(command.out)['topics']
    assert topic['grid']['lost'] == 7


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_run_stopped_by_the_operator_keeps_its_bag(lab, number):
    out = lab.folder / 'out'
    endless = given(SHORT | {'excitation.duration': 4000.0, 'run.rate': 500.0})
    command = lab.cli('run', *endless, '--out', str(out), '--json')
    wait_until(lambda: sum(f.stat().st_size for f in out.glob('*.mcap')) > 100_000, 'a bag')
    command.signal(number)
    assert command.code() == 1
    assert 'stopped by the operator; kept' in command.log and 'Traceback' not in command.log
    assert command.out == ''
    bag = info(out)
    assert bag.closed and bag.lossless and bag.run['state'] == 'aborted'
    shutil.rmtree(out)
