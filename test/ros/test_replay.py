"""A bag put back on the air: bit by bit what was recorded."""

from __future__ import annotations

import pytest
from ros_support import SHORT, Lab, document, kept, read, same_bits

from qzs_rig import wire
from qzs_rig.bag import BagReader, BagWriter, TopicSpec

SPEC = SHORT | {'sensor.kind': 'noisy', 'run.seed': 11, 'platform.zeta': 0.07}


@pytest.fixture(scope='module')
def recorded(tmp_path_factory):
    """A run of the nodes, with noise, and with a parameter that is not the default."""
    with Lab(tmp_path_factory.mktemp('recorded')) as lab:
        assert [node.code() for node in lab.rig(SPEC)] == [0, 0, 0]
        yield lab.folder / 'out'


@pytest.mark.parametrize(
    ('topics', 'start'), [('motion', ('platform', 'analyzer')), ('imu', ('analyzer',))]
)
def test_same_bits(lab, recorded, topics, start):
    out = lab.folder / 'again'
    words = ('replay', str(recorded), '--topics', topics, '--start', *start, '--out', str(out))
    command = lab.cli(*words, '--json')
    assert command.code() == 0, command.log
    run, estimate = kept(out)
    assert estimate == document(recorded / 'estimate.json')
    assert all(c['lost'] == 0 for c in run['topics'].values())
    before, after = read(recorded)[2], read(out)[2]
    for a, b in zip(before, after, strict=True):
        assert (a.stamps_ns == b.stamps_ns).all() and same_bits(a.data, b.data)


def test_twenty_times_real_time(lab, recorded):
    out = lab.folder / 'again'
    command = lab.cli(
        *('replay', str(recorded), '--topics', 'imu', '--rate', '20'),
        *('--start', 'analyzer', '--out', str(out)),
    )
    assert command.code() == 0, command.log
    run, estimate = kept(out)
    assert estimate == document(recorded / 'estimate.json')
    # 10 s of rig time at 20 times real time, from the first to the last batch of 20 rig ms
    assert 0.4 < run['wall_s'] < 3.0


def without_sheet(bag, out):
    """The same bag as somebody else would have recorded it."""
    reader = BagReader(bag)
    topics = [('base/motion', wire.BASE_MOTION.type), ('base/imu', wire.BASE_IMU.type)]
    topics.append(('top/imu', wire.TOP_IMU.type))
    writer = BagWriter(out, [TopicSpec(name, kind, 10) for name, kind in topics])
    try:
        for name, kind in topics:
            rows = reader.rows(name, kind)
            writer.write(name, rows.stamps_ns, rows.messages())
    finally:
        writer.close()
        reader.close()
    return out


def test_refusals(lab, recorded):
    """One line each, exit code 2."""
    foreign = without_sheet(recorded, lab.folder / 'foreign')
    (lab.folder / 'full').mkdir()
    (lab.folder / 'full' / 'mine').write_text('mine')
    full = str(lab.folder / 'full')
    cases = {
        'out of range': (recorded, '--rate', '0'),
        'give a factor above 0': (recorded, '--rate', '1e9'),
        'no run sheet on rig/run; only topics:=imu': (foreign, '--topics', 'motion'),
        'is occupied; nothing is overwritten': (
            *(recorded, '--start', 'platform', 'analyzer', '--out', full),
        ),
        'does not exist; give a bag': (lab.folder / 'nowhere',),
    }
    commands = {text: lab.cli('replay', *map(str, words)) for text, words in cases.items()}
    for text, command in commands.items():
        assert command.code() == 2, (text, command.log)
        assert text in command.log
        assert 'Traceback' not in command.log and command.out == ''
    assert (lab.folder / 'full' / 'mine').read_text() == 'mine'


def test_imu_of_a_bag_without_sheet(lab, recorded):
    """Somebody else's bag: the step is read off its stamps, the estimate is that of `analyze`."""
    foreign = without_sheet(recorded, lab.folder / 'foreign')
    out = lab.folder / 'out'
    replay = lab.cli(
        *('replay', str(foreign), '--topics', 'imu', '--start', 'analyzer', '--out', str(out)),
    )
    analyze = lab.cli('analyze', str(foreign), '--out', str(lab.folder / 'offline'))
    assert replay.code() == 0, replay.log
    assert analyze.code() == 0, analyze.log
    offline = document(lab.folder / 'offline' / 'estimate.json')
    live = kept(out)[1]
    assert live['curves'] == offline['curves'] and live['events'] == offline['events']
