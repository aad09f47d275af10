"""A node of a run is killed, frozen or missing: the others notice, name it, and close."""

from __future__ import annotations

import signal
import time

import numpy as np
import pytest
from ros_support import LONG, ROLES, SHORT, kept, read, wait_until

from qzs_rig import wire
from qzs_rig.bag import BagReader, info, recover
from qzs_rig.errors import BagError

NOTICE_S = 1.0
"""What the rig promises, from the death to the others' word."""
CLOSING_S = 1.0
"""What two processes may take to close files and end on a machine that is busy elsewhere."""
SPEC = LONG | {'run.rate': 500.0}
NAMES = {'exciter': 'the exciter (or player)', 'platform': 'platform', 'analyzer': 'analyzer'}


def running(lab, parameters=SPEC):
    """A run by the clock that is half a second old, and ears on its base sensor."""
    ears = lab.ears(wire.BASE_IMU)
    nodes = dict(zip(ROLES, lab.rig(parameters), strict=True))
    ears.wait('base/imu', 250)
    return ears, nodes


def finds_out(nodes, dead, since):
    """The survivors say who died, and end with code 1; returns them."""
    left = [node for role, node in nodes.items() if role != dead]
    for node in left:
        wait_until(
            lambda node=node: not node.running or 'died or was cut off' in node.log,
            lambda node=node: f'{node.name} did not notice; it said:\n{node.log}',
        )
    noticed = time.monotonic() - since
    assert noticed < NOTICE_S + 0.2, f'noticed after {noticed:.2f} s'  # 0.2: polling and the log
    assert [node.code() for node in left] == [1, 1]
    gone = max(node.ended_at for node in left) - since
    logs = '\n'.join(f'{node.name} {node.ended_at - since:.2f} s\n{node.log}' for node in left)
    assert gone < NOTICE_S + CLOSING_S, f'gone after {gone:.2f} s\n{logs}'
    for node in left:
        assert NAMES[dead] in node.log, logs
        assert 'Traceback' not in node.log
    return left


@pytest.mark.parametrize('dead', ['exciter', 'platform'])
def test_killed(lab, dead):
    _, nodes = running(lab)
    since = nodes[dead].signal(signal.SIGKILL)
    finds_out(nodes, dead, since)
    run, estimate = kept(lab.folder / 'out')
    assert run['state'] == 'aborted' and f'{NAMES[dead]} died' in run['reason']
    assert estimate['schema'] == 'qzs_rig/estimate/1'
    assert info(lab.folder / 'out').closed
    sheets, _, imus = read(lab.folder / 'out')
    assert sheets[-1].state == 'aborted'
    for imu, topic in zip(imus, ('base/imu', 'top/imu'), strict=True):
        # the ears had 250; to the analyzer some were under way when the platform died
        assert len(imu.stamps_ns) == run['topics'][topic]['received'] > 200
        assert run['topics'][topic]['lost'] == 0


def test_killed_analyzer_leaves_a_bag_that_can_be_recovered(lab):
    ears, nodes = running(lab)
    wait_until(lambda: len(ears.got['base/imu']) > 600, 'more than a second of samples')
    # what another subscriber had by then; what was under way to it is a few ms
    published = len(ears.got['base/imu'])
    since = nodes['analyzer'].signal(signal.SIGKILL)
    finds_out(nodes, 'analyzer', since)
    bag = lab.folder / 'out'
    with pytest.raises(BagError, match=r'was not closed.*qzs-rig bag recover'):
        BagReader(bag)
    report = recover(bag, lab.folder / 'saved')
    saved = report.messages['/base/imu']
    assert published - saved <= 0.3 * 500, f'{published - saved} of {published} samples lost'
    _, chunks, imus = read(lab.folder / 'saved')
    assert (np.diff(imus[0].stamps_ns) == 2_000_000).all()
    assert len(imus[0].stamps_ns) == saved and len(chunks) > 0


def test_frozen_platform(lab):
    """SIGSTOP: a process that stalls for longer than its lease counts as dead."""
    _, nodes = running(lab)
    since = nodes['platform'].signal(signal.SIGSTOP)
    finds_out(nodes, 'platform', since)
    assert kept(lab.folder / 'out')[0]['state'] == 'aborted'
    nodes['platform'].signal(signal.SIGCONT)
    # when it comes back, there is nobody left
    assert nodes['platform'].code() == 1


def test_killed_in_lockstep(lab):
    """Amid thousands of messages a second."""
    spec = SHORT | {'run.rate': 500.0, 'excitation.duration': 3000.0}
    _, nodes = running(lab, spec)
    since = nodes['platform'].signal(signal.SIGKILL)
    finds_out(nodes, 'platform', since)
    run, _ = kept(lab.folder / 'out')
    assert run['state'] == 'aborted' and 'platform died' in run['reason']
    assert info(lab.folder / 'out').closed


def test_lead_replaced_while_waiting(lab):
    """A lead that dies before the run takes nobody with it: another one leads."""
    first = lab.node('exciter')
    platform = lab.node('platform')
    first.says('node analyzer')
    platform.says('waiting for')
    first.signal(signal.SIGKILL)
    second = lab.node('exciter', SHORT, peers='platform')
    assert [node.code() for node in (second, platform)] == [0, 0]
    assert 'run finished' in platform.log
