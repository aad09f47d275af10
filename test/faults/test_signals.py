"""SIGINT and SIGTERM to `qzs-rig rig` and to single nodes, at every moment of a run."""

from __future__ import annotations

import json
import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest
from ros_support import SHORT, given, kept, read, wait_until

from qzs_rig.bag import info
from qzs_rig.ros.lead import IN_FLIGHT

CLOSING_S = 2.0
"""What the rig promises, from the signal to the last process."""
OVERHEAD_S = 1.0
"""Interpreters that end, and the report of what there is, on a machine that is busy elsewhere."""
ENDLESS = given(SHORT | {'excitation.duration': 3000.0, 'run.rate': 500.0})
BY_THE_CLOCK = [*given(SHORT | {'excitation.duration': 1.0, 'run.rate': 500.0}), '--real-time']


def started(lab, *words):
    """`qzs-rig rig WORDS` with a folder for scratch files that nobody else uses."""
    scratch = lab.folder / 'scratch'
    scratch.mkdir()
    lab.env['TMPDIR'] = str(scratch)
    command = lab.cli('rig', 'vertical_sweep', *words, '--out', str(lab.folder / 'out'), '--json')
    return command, scratch


def family(domain):
    """Processes of this test, by the domain in their environment: orphans are among them."""
    mark = f'ROS_DOMAIN_ID={domain}\0'.encode()
    found = []
    for folder in Path('/proc').iterdir():
        if folder.name.isdigit() and int(folder.name) != os.getpid():
            try:
                own = mark in (folder / 'environ').read_bytes()
                alive = (folder / 'stat').read_text().rsplit(') ', 1)[1][0] != 'Z'
            except OSError:
                continue
            if own and alive:
                found.append(int(folder.name))
    return found


def nodes_up(lab, count):
    """Wait for that many node processes."""
    wait_until(lambda: len(family(lab.domain)) > count, f'{count} nodes')


def recorded(lab, size=20_000):
    """Wait until the bag has grown to `size` bytes on the disk."""

    def grown():
        return sum(f.stat().st_size for f in (lab.folder / 'out').glob('*.mcap')) > size

    wait_until(grown, 'a bag that grows')


def whole(bag):
    """Both sensors without a gap from the first sample; one may end before the other, by no more
    than what may be under way when a run is cut short."""
    sheets, _, imus = read(bag)
    for imu in imus:
        grid = sheets[-1].start_ns + np.arange(len(imu.stamps_ns)) * sheets[-1].step_ns
        assert len(grid) > 0 and (imu.stamps_ns == grid).all()
    assert abs(len(imus[0].stamps_ns) - len(imus[1].stamps_ns)) <= IN_FLIGHT


def closes(lab, command, scratch, number):
    since = command.signal(number)
    assert command.code() == 1, command.log
    took = command.ended_at - since
    assert took < CLOSING_S + OVERHEAD_S, f'closed after {took:.2f} s\n{command.log}'
    assert family(lab.domain) == []
    assert list(scratch.iterdir()) == []
    assert 'Traceback' not in command.log
    assert 'stop' in command.log


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize('moment', [1, 3])
def test_while_starting(lab, number, moment):
    """With one process up, and with all of them, before any sample."""
    command, scratch = started(lab, *ENDLESS)
    nodes_up(lab, moment)
    closes(lab, command, scratch, number)


def in_the_background(lab):
    """From now on processes start as a shell's background jobs do: with SIGINT ignored."""
    lab.prefix = ('/bin/sh', '-c', 'trap "" INT; exec "$@"', 'sh')


def test_in_the_background(lab):
    """A shell ignores SIGINT for the jobs that it starts in the background; we do not."""
    in_the_background(lab)
    command, scratch = started(lab, *ENDLESS)
    recorded(lab)
    closes(lab, command, scratch, signal.SIGINT)
    assert kept(lab.folder / 'out')[0]['reason'] == 'stopped by SIGINT'


def test_a_node_in_the_background(lab):
    in_the_background(lab)
    node = lab.node('exciter')
    node.says('waiting for node platform')
    node.signal(signal.SIGINT)
    assert node.code() == 0
    assert 'SIGINT: closing' in node.log


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_in_the_middle(lab, number):
    command, scratch = started(lab, *ENDLESS)
    recorded(lab)
    closes(lab, command, scratch, number)
    run, _ = kept(lab.folder / 'out')
    assert json.loads(command.out) == run
    assert (run['state'], run['reason']) == ('aborted', 'stopped by SIGINT')
    bag = info(lab.folder / 'out')
    assert bag.closed and not bag.damage and bag.run['state'] == 'aborted'
    whole(lab.folder / 'out')
    counts = {topic.name.lstrip('/'): topic.count for topic in bag.topics}
    assert counts['base/imu'] == run['topics']['base/imu']['received'] > 0
    assert (lab.folder / 'out' / 'report.html').is_file()


def test_near_the_end(lab):
    """In the last half second of a run by the clock: whatever the race gives, it is consistent."""
    command, scratch = started(lab, *BY_THE_CLOCK)
    recorded(lab, 1)
    time.sleep(2.8)  # of 3 s of run time
    since = command.signal(signal.SIGINT)
    code = command.code()
    assert command.ended_at - since < CLOSING_S + OVERHEAD_S
    assert family(lab.domain) == [] and list(scratch.iterdir()) == []
    run, _ = kept(lab.folder / 'out')
    assert code == (0 if run['state'] == 'finished' else 1)
    whole(lab.folder / 'out')


def test_twice_in_a_row(lab):
    """An impatient second Ctrl-C leaves nothing behind either."""
    command, scratch = started(lab, *ENDLESS)
    recorded(lab)
    since = command.signal(signal.SIGINT)
    time.sleep(0.1)
    command.signal(signal.SIGINT)
    assert command.code() == 1
    assert command.ended_at - since < CLOSING_S + OVERHEAD_S
    assert family(lab.domain) == [] and list(scratch.iterdir()) == []
    assert 'Traceback' not in command.log
    assert info(lab.folder / 'out').closed


@pytest.mark.parametrize('role', ['exciter', 'platform', 'analyzer'])
def test_one_node_is_stopped(lab, role):
    """The operator's stop of a single node ends the run: in order, with its reason, at once."""
    spec = SHORT | {'excitation.duration': 3000.0, 'run.rate': 500.0}
    nodes = dict(zip(('exciter', 'platform', 'analyzer'), lab.rig(spec), strict=True))
    recorded(lab)
    since = nodes[role].signal(signal.SIGTERM)
    codes = {name: node.code() for name, node in nodes.items()}
    assert max(node.ended_at for node in nodes.values()) - since < CLOSING_S
    assert codes.pop(role) == 0 and set(codes.values()) == {1}
    run, _ = kept(lab.folder / 'out')
    assert run['state'] == 'aborted' and 'stopped by SIGTERM' in run['reason']
    whole(lab.folder / 'out')
