"""The operator's verbs: configure, activate, deactivate, cleanup and ~/abort, over services."""

from __future__ import annotations

import signal
import sys
import time

import numpy as np
import pytest
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from ros_support import LONG, SAMPLES, SHORT, kept, read, wait_until, without_ros
from std_srvs.srv import Trigger

from qzs_rig import wire
from qzs_rig.ros.node import ANSWER_S

SERVICES = (
    ('exciter/change_state', ChangeState),
    ('exciter/get_state', GetState),
    ('exciter/set_parameters', SetParameters),
    ('exciter/abort', Trigger),
)
VERBS = {
    'configure': Transition.TRANSITION_CONFIGURE,
    'activate': Transition.TRANSITION_ACTIVATE,
    'deactivate': Transition.TRANSITION_DEACTIVATE,
    'cleanup': Transition.TRANSITION_CLEANUP,
}


def tell(ears, verb):
    request = ChangeState.Request(transition=Transition(id=VERBS[verb]))
    return ears.call('exciter/change_state', request).success


def state(ears):
    return ears.call('exciter/get_state').current_state.label


@pytest.mark.parametrize('how', ['deactivate', 'abort'])
def test_stopped_softly(lab, how):
    """A run in real time that is stopped ramps down: the base ends at rest, the sheet says why."""
    ears = lab.ears(wire.BASE_MOTION, services=SERVICES)
    nodes = lab.rig(LONG)
    ears.wait('base/motion', 10)
    wait_until(lambda: len(ears.got['base/motion']) > 60, 'one second of motion')
    if how == 'deactivate':
        assert tell(ears, 'deactivate')
    else:
        assert ears.call('exciter/abort').success
    assert [node.code() for node in nodes] == [1, 1, 1]

    by = {'deactivate': 'deactivated', 'abort': 'aborted'}[how]
    run = kept(lab.folder / 'out')[0]
    assert (run['state'], run['reason']) == ('aborted', f'{by} by the operator')
    assert all(count['lost'] == 0 for count in run['topics'].values())
    sheets, chunks, imus = read(lab.folder / 'out')
    motion = np.concatenate([chunk.data for chunk in chunks])
    # the ramp of 1 s is at least 200 samples, and was performed whole
    assert len(motion) == sheets[-1].samples == len(imus[0].stamps_ns)
    loudest = np.abs(motion[:, :8]).max()
    assert loudest > 1e-4
    # position and velocity of the envelope are exactly 0 where it ends
    assert np.abs(motion[-1, :8]).max() < 1e-12
    # and no step on the way: acceleration stays within twice the commanded amplitude
    assert np.abs(motion[:, 8:]).max() < 2.0


def test_started_by_a_supervisor(lab):
    """autostart false: nothing until configure and activate; exit_when_done false: twice."""
    ears = lab.ears(wire.RUN, services=SERVICES)
    own = {'autostart': False, 'exit_when_done': False}
    exciter = lab.node('exciter', SHORT, **own)
    platform = lab.node('platform', SHORT, exit_when_done=False)
    first = lab.node('analyzer', SHORT, folder=str(lab.folder / 'first'))
    assert state(ears) == 'unconfigured'
    assert tell(ears, 'configure') and state(ears) == 'inactive'
    assert ears.got['rig/run'] == []
    assert tell(ears, 'activate') and state(ears) == 'active'
    assert first.code() == 0
    assert kept(lab.folder / 'first')[1] == without_ros(SHORT)[0]

    # a second run with another amplitude, set as `ros2 param set` does
    wait_until(lambda: ears.sheets()[-1].state == 'finished', 'the first run to end')
    assert tell(ears, 'deactivate') and tell(ears, 'cleanup') and state(ears) == 'unconfigured'
    name = 'excitation.amplitude.vertical'
    louder = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=1.5)
    request = SetParameters.Request(parameters=[Parameter(name=name, value=louder)])
    assert ears.call('exciter/set_parameters', request).results[0].successful
    assert tell(ears, 'configure') and tell(ears, 'activate')
    second = lab.node('analyzer', SHORT, folder=str(lab.folder / 'second'))
    assert second.code() == 0
    run, estimate = kept(lab.folder / 'second')
    assert all(c['received'] == SAMPLES and c['lost'] == 0 for c in run['topics'].values())
    assert estimate == without_ros(SHORT | {name: 1.5})[0]
    assert exciter.running and platform.running


def test_deactivated_while_it_waits(lab):
    """Nobody starts a run whose lead was deactivated."""
    ears = lab.ears(wire.RUN, wire.BASE_MOTION, services=SERVICES)
    exciter = lab.node('exciter', SHORT, exit_when_done=False)
    exciter.says('waiting for node platform')
    assert tell(ears, 'deactivate') and state(ears) == 'inactive'
    platform, analyzer = lab.node('platform'), lab.node('analyzer', folder=str(lab.folder / 'out'))
    wait_until(lambda: 'aborted' in [s.state for s in ears.sheets()], 'the sheet to be withdrawn')
    ears.known_to('exciter')
    assert ears.got['base/motion'] == []
    assert not (lab.folder / 'out').exists()
    assert platform.running and analyzer.running


CALLER = """
import os
import signal

import rclpy
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState

rclpy.init()
node = rclpy.create_node('caller')
change = node.create_client(ChangeState, 'exciter/change_state')
look = node.create_client(GetState, 'exciter/get_state')
for client in (change, look):
    client.wait_for_service()
rclpy.spin_until_future_complete(node, look.call_async(GetState.Request()))
verb = Transition(id=Transition.TRANSITION_DEACTIVATE)
future = change.call_async(ChangeState.Request(transition=verb))
os.kill(os.getpid(), signal.SIGSTOP)
rclpy.spin_until_future_complete(node, future, timeout_sec=20.0)
print(future.result(), flush=True)
node.destroy_node()
rclpy.shutdown()
"""


SLOW = """
import sys
import time

from qzs_rig.ros import exciter

halt = exciter.Exciter.halt

def slowly(self):
    time.sleep(float(sys.argv.pop(1)))
    halt(self)

exciter.Exciter.halt = slowly
exciter.main()
"""


@pytest.mark.parametrize('work_s', [0.0, 1.5])
def test_a_slow_caller_gets_the_answer_of_a_node_that_ends(lab, work_s):
    """The node ends because of the call; its answer must not be overtaken by its leaving, however
    long the work for it took."""
    words = [word for name, value in SHORT.items() for word in ('-p', f'{name}:={value}')]
    command = [sys.executable, '-c', SLOW, str(work_s), '--ros-args', *words]
    exciter = lab.run('exciter', command)
    exciter.says('waiting for node platform')
    caller = lab.run('caller', [sys.executable, '-c', CALLER])
    exciter.says('aborted: deactivated by the operator')
    (line,) = (line for line in exciter.log.splitlines() if 'aborted: deactivated' in line)
    ended = float(line.split('[')[2].split(']')[0])  # the log's stamp of the end of the work
    wait_until(lambda: not exciter.running or time.time() > ended + ANSWER_S / 2, 'half the wait')
    # the caller is still there, so the node must be; unless this test was itself held up
    assert exciter.running or time.time() > ended + ANSWER_S
    caller.signal(signal.SIGCONT)
    assert caller.code() == 0, caller.log
    assert 'success=True' in caller.out
    assert exciter.code() == 1
