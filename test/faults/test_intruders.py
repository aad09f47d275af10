"""Others on the rig's topics: wrong types, wrong QoS, silent nodes, a second analyzer, gaps."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from rclpy.qos import qos_profile_sensor_data
from ros_support import SAMPLES, SHORT, kept, read, wait_until
from sensor_msgs.msg import Imu

from qzs_rig import scenario, wire
from qzs_rig.ros.lead import IN_FLIGHT
from qzs_rig.run.sheet import RunSheet
from qzs_rig.run.stages import ExciterStage

NOISE = wire.Topic('base/imu', 'std_msgs/msg/String', 10)


def test_wrong_type_on_a_topic_of_the_rig(lab):
    """Another type on base/imu never reaches the analyzer."""
    ears = lab.ears(publishers=(NOISE,))
    nodes = lab.rig()
    from std_msgs.msg import String

    while any(node.running for node in nodes):
        ears.publish['base/imu'].publish(String(data='noise'))
        time.sleep(0.01)
    assert [node.code() for node in nodes] == [0, 0, 0]
    run = kept(lab.folder / 'out')[0]
    assert [c['received'] for c in run['topics'].values()] == [SAMPLES, SAMPLES]


def test_incompatible_offer_is_named(lab):
    """A best-effort driver against an analyzer that asks for reliability."""
    ears = lab.ears()
    ears.node.create_publisher(Imu, 'base/imu', qos_profile_sensor_data)
    analyzer = lab.node('analyzer', {'analyzer.source': 'driver'})
    analyzer.says('base/imu')
    analyzer.says('RELIABILITY')
    line = next(x for x in analyzer.log.splitlines() if 'RELIABILITY' in x)
    assert line.startswith('[ERROR]') and 'base/imu' in line
    assert 'analyzer.qos' in line and 'sensor_data' in line


def test_a_second_analyzer_is_counted_honestly(lab):
    """Two nodes that call themselves analyzer share one credit; what one misses is said."""
    exciter = lab.node('exciter')
    first = lab.node('analyzer', folder=str(lab.folder / 'first'))
    second = lab.node(
        'analyzer', SHORT, ('-r', '__node:=second'), folder=str(lab.folder / 'second')
    )
    first.says('waiting')
    second.says('waiting')
    platform = lab.node('platform')
    assert [node.code() for node in (exciter, platform, first, second)] == [0, 0, 0, 0]
    for name in ('first', 'second'):
        run = kept(lab.folder / name)[0]
        _, _, imus = read(lab.folder / name)
        for topic, imu in zip(('base/imu', 'top/imu'), imus, strict=True):
            count = run['topics'][topic]
            assert count['published'] == SAMPLES
            assert count['received'] == len(imu.stamps_ns) == SAMPLES - count['lost']


def test_silent_node_instead_of_the_platform(lab):
    """Somebody listens on base/motion but never speaks as the platform: the lead waits, says so."""
    ears = lab.ears(wire.BASE_MOTION)
    exciter = lab.node('exciter')
    analyzer = lab.node('analyzer', folder=str(lab.folder / 'out'))
    exciter.says('waiting for node platform')
    ears.known_to('exciter')
    analyzer.says('waiting for')
    # the same words every five seconds, and nothing else comes of it

    def reminded(node):
        words = Counter(line.rsplit(']: ')[-1] for line in node.log.splitlines())
        return max(words.values()) >= 2

    for node in (exciter, analyzer):
        wait_until(lambda node=node: reminded(node), f'a reminder of the {node.name}')
    assert exciter.running and analyzer.running
    assert ears.got['base/motion'] == []
    assert not (lab.folder / 'out').exists()


SPEC = scenario.of(SHORT)
STEP_NS = 5_000_000
START_NS = 1_700_000_000_000_000_000


def started():
    """An exciter at the start of the run."""
    stage = ExciterStage(SPEC, STEP_NS)
    stage.start(START_NS)
    return stage


class FakeLead:
    """Leads a run as the exciter does, but publishes what the test wants."""

    def __init__(self, lab):
        self.ears = lab.ears(
            wire.PLATFORM_STATUS, wire.TOP_IMU, publishers=(wire.RUN, wire.BASE_MOTION)
        )
        self.sheet = RunSheet(
            step_ns=STEP_NS, samples=SAMPLES, mode='lockstep', chunk=40, spec=dict(SPEC),
            run_id='fake', scenario='fake', peers=('platform',), start_ns=START_NS,
        )  # fmt: skip
        self.stage = started()

    def say(self, state):
        self.ears.publish['rig/run'].publish(
            wire.encode_json(self.sheet.replace(state=state).to_document())
        )

    def status(self):
        got = self.ears.got['platform/status']
        return wire.decode_status(got[-1]) if got else wire.Status('', 0, '', {})

    def start(self):
        self.say('waiting')
        wait_until(lambda: self.status().values.get('state') == 'ready', 'a ready platform')
        wait_until(self.ears.publish['base/motion'].get_subscription_count, 'the platform')
        self.say('armed')
        wait_until(lambda: self.status().values.get('state') in ('armed', 'running'), 'armed')

    def chunk(self, shift_ns=0):
        motion = self.stage.take(40)
        motion = replace(motion, stamps_ns=motion.stamps_ns + shift_ns)
        self.ears.publish['base/motion'].publish(wire.encode_motion(motion))


@pytest.mark.parametrize(
    ('fault', 'message'),
    [
        ('lost', 'base motion jumped from sample 40 to 80; the run cannot go on: raise the QoS'),
        ('again', 'base motion jumped from sample 40 to 0'),
        ('off', 'lies 1000 ns off the 5000000 ns sample grid'),
    ],
)
def test_platform_refuses_a_gap(lab, fault, message):
    platform = lab.node('platform')
    lead = FakeLead(lab)
    lead.start()
    lead.chunk()
    wait_until(lambda: lead.status().values.get('index') == '40', 'the first chunk')
    if fault == 'lost':
        lead.stage.take(40)
    elif fault == 'again':
        lead.stage = started()
    lead.chunk(1000 if fault == 'off' else 0)
    assert platform.code() == 3
    assert message in platform.log
    wait_until(lambda: lead.status().values.get('state') == 'failed', 'the word to the lead')
    assert message in lead.status().message and lead.status().level == wire.LEVEL['error']
    assert len(lead.ears.wait('top/imu', 40)) == 40


def test_platform_that_lives_but_does_nothing(lab):
    """In lockstep everybody waits for everybody; one that hangs must not hang them all."""
    ears = lab.ears(wire.RUN, wire.BASE_MOTION, publishers=(wire.PLATFORM_STATUS,))
    exciter = lab.node('exciter', SHORT, peers='platform')

    def say(state):
        values = {'state': state, 'run_id': ears.sheets()[-1].run_id, 'index': '0', 'spec': '{}'}
        status = wire.Status('platform', 0, state, values)
        ears.publish['platform/status'].publish(wire.encode_status(status))

    ears.wait('rig/run')
    say('ready')
    wait_until(lambda: ears.sheets()[-1].state == 'armed', 'the run to be armed')
    say('armed')
    ears.wait('base/motion')
    assert exciter.code() == 1
    assert 'platform stayed at sample 0 for 5 s' in exciter.log
    last = ears.sheets()[-1]
    assert (last.state, last.reason) == ('aborted', 'platform stayed at sample 0 for 5 s')
    # no more than what may be under way was published to it
    assert len(ears.got['base/motion']) * 40 <= IN_FLIGHT


@pytest.mark.parametrize(
    ('message', 'complaint'),
    [
        (wire.encode_status(wire.Status('thief', 0, '', {'spec': '{'})), 'thief/status is none of'),
        (b'\0\1\0\0\1\0\0\0', 'a message of 8 bytes is no diagnostic_msgs/msg/DiagnosticStatus'),
    ],
    ids=['of another program', 'torn'],
)
def test_a_stranger_on_a_status_is_named_and_ignored(lab, message, complaint):
    ears = lab.ears(publishers=(wire.PLATFORM_STATUS,))
    exciter = lab.node('exciter')
    exciter.says('waiting for')
    ears.known_to('exciter')
    ears.publish['platform/status'].publish(message)
    exciter.says(f'platform/status: {complaint}')
    others = lab.node('platform'), lab.node('analyzer', folder=str(lab.folder / 'out'))
    assert [node.code() for node in (exciter, *others)] == [0, 0, 0]


def test_large_chunks_still_move(lab):
    """run.chunk may be larger than what is let into flight at once."""
    nodes = lab.rig(SHORT | {'run.chunk': 1000})
    assert [node.code() for node in nodes] == [0, 0, 0]
    run = kept(lab.folder / 'out')[0]
    assert [c['received'] for c in run['topics'].values()] == [SAMPLES, SAMPLES]


def test_divergence_ends_the_run_with_finite_numbers(lab):
    """Beyond its geometry the model stops; what was published by then is finite."""
    spec = SHORT | {
        'platform.law': 'closed_form',
        'excitation.amplitude.vertical': 0.0,
        'excitation.amplitude.horizontal_rotation': 60.0,
        'shaker.limits': False,
    }
    nodes = lab.rig(spec)
    codes = [node.code() for node in nodes]
    run = kept(lab.folder / 'out')[0]
    assert codes == [1, 1, 1] and run['state'] == 'aborted'
    assert run['reason'].startswith('platform: ') and 'sample' in run['reason']
    _, _, imus = read(lab.folder / 'out')
    for imu in imus:
        assert 0 < len(imu.data) < SAMPLES and np.isfinite(imu.data).all()
