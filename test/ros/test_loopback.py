"""Nodes keep to 127.0.0.1, leave nothing behind when killed, and still talk to everybody here."""

from __future__ import annotations

import errno
import signal
import sys
from pathlib import Path

import pytest
from ros_support import SHORT, kept, wait_until

from qzs_rig import loopback, wire
from qzs_rig.errors import InputError, PeerError

SHARED = Path('/dev/shm')
PROFILES = 'FASTDDS_DEFAULT_PROFILES_FILE'
STRANGER = """
import sys
import rclpy
from std_srvs.srv import Trigger
from std_msgs.msg import String
from rclpy.qos import DurabilityPolicy, QoSProfile

rclpy.init()
node = rclpy.create_node('stranger')
sheets = []
latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
node.create_subscription(String, 'rig/run', sheets.append, latched)
abort = node.create_client(Trigger, 'exciter/abort')
while not (sheets and abort.service_is_ready()):
    rclpy.spin_once(node, timeout_sec=0.1)
future = abort.call_async(Trigger.Request())
rclpy.spin_until_future_complete(node, future)
print(future.result().message, flush=True)
node.destroy_node()
rclpy.shutdown()
"""


def sockets(pid):
    """Local IPv4 addresses of the UDP sockets of a process, as /proc writes them."""
    links = [link for link in Path(f'/proc/{pid}/fd').iterdir() if link.is_symlink()]
    inodes = {str(link.readlink()) for link in links}
    rows = [row.split() for row in Path('/proc/net/udp').read_text().splitlines()[1:]]
    return [row[1].split(':')[0] for row in rows if f'socket:[{row[9]}]' in inodes]


def shared_memory():
    """Names of Fast DDS's files in shared memory."""
    return {path.name for path in SHARED.iterdir() if 'fastdds' in path.name}


def test_sockets_on_127_0_0_1_and_nothing_left_by_the_killed(lab):
    before = shared_memory()
    nodes = lab.rig(SHORT | {'excitation.duration': 3000.0})
    wait_until(lambda: list((lab.folder / 'out').glob('*.mcap')), 'a run')
    for node in nodes:
        found = sockets(node.pid)
        assert found and set(found) == {'0100007F'}, (node.name, found)
    for node in nodes:
        node.signal(signal.SIGKILL)
    for node in nodes:
        assert node.code() == -signal.SIGKILL
    assert shared_memory() == before


def test_a_killed_rig_hinders_no_other_in_its_domain(lab):
    """The same ports again, at once, five times."""
    for turn in range(5):
        nodes = lab.rig(SHORT | {'excitation.duration': 3000.0}, out=f'killed {turn}')
        bag = lab.folder / f'killed {turn}'
        wait_until(lambda bag=bag: list(bag.glob('*.mcap')), 'a run')
        for node in nodes:
            node.signal(signal.SIGKILL)
        for node in nodes:
            node.code()
    assert [node.code() for node in lab.rig()] == [0, 0, 0]
    assert kept(lab.folder / 'out')[0]['state'] == 'finished'


def test_a_tool_without_the_profile_hears_and_is_answered(lab):
    """`ros2 topic` and `ros2 service` in a shell that holds no more than LOCALHOST."""
    exciter = lab.node('exciter')
    exciter.says('waiting for node platform')
    stranger = lab.run('stranger', [sys.executable, '-c', STRANGER])
    assert stranger.code() == 0, stranger.log
    assert stranger.out == 'no run is on (waiting)\n'


def test_a_profile_of_the_users_own_is_left_alone(lab):
    """The node runs with what it names: here, a participant of another name."""
    own = lab.folder / 'own.xml'
    own.write_text(
        '<profiles xmlns="http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles">'
        '<participant profile_name="own" is_default_profile="true"/></profiles>'
    )
    lab.env[PROFILES] = str(own)
    node = lab.node('exciter')
    node.says('waiting for node platform')
    assert '00000000' in sockets(node.pid)  # Fast DDS's own choice: every interface
    node.signal(signal.SIGINT)  # in order: this one has shared memory
    assert node.code() == 0


@pytest.mark.parametrize(
    'more',
    [
        {loopback.RANGE: 'SUBNET'},
        {loopback.RANGE: ''},
        {PROFILES: '/mine.xml'},
        {'FASTRTPS_DEFAULT_PROFILES_FILE': '/mine.xml'},
        {'ROS_STATIC_PEERS': '192.0.2.7'},
        {'RMW_IMPLEMENTATION': 'rmw_cyclonedds_cpp'},
    ],
)
def test_what_the_user_chose_is_left_alone(more):
    environment = {loopback.RANGE: 'LOCALHOST'} | more
    before = dict(environment)
    loopback.settle(environment)
    assert environment == before


@pytest.mark.parametrize(
    ('distro', 'name'), [('kilted', PROFILES), ('jazzy', 'FASTRTPS_DEFAULT_PROFILES_FILE')]
)
def test_the_profile_comes_into_force(distro, name):
    environment = {
        loopback.RANGE: 'LOCALHOST', 'ROS_DISTRO': distro, 'ROS_LOCALHOST_ONLY': '1',
    }  # fmt: skip
    loopback.settle(environment)
    assert 'ROS_LOCALHOST_ONLY' not in environment
    assert environment[loopback.RANGE] == 'SYSTEM_DEFAULT'
    assert Path(environment[name]).is_file()


def test_a_profile_that_is_missing_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(loopback.scenario, 'config_folder', lambda: tmp_path)
    with pytest.raises(InputError, match=r'fastdds\.xml is missing; install qzs_rig again'):
        loopback.settle({loopback.RANGE: 'LOCALHOST'})


def test_where_no_domain_can_be_reserved(monkeypatch):
    """A system without names for sockets is not taken for one whose domains are in use."""

    class Forbidden:
        def __init__(self, *kind):
            pass

        def bind(self, name):
            raise PermissionError(errno.EPERM, 'not permitted')

        def close(self):
            pass

    monkeypatch.setattr(loopback.socket, 'socket', Forbidden)
    with pytest.raises(PeerError, match=r'reserved \(not permitted\); choose one with ROS_DOMAIN'):
        loopback.reserve_domain()


def test_no_domain_is_given_twice(monkeypatch):
    monkeypatch.setattr(loopback, 'DOMAINS', range(1, 6))
    monkeypatch.setattr(loopback, '_bound_ports', lambda: {7400 + 250 * 2 + 10})
    held = []
    try:
        with pytest.raises(PeerError, match='all ROS domains from 1 to 5 are in use'):
            while True:
                held.append(loopback.reserve_domain())
        numbers = [domain.number for domain in held]
        # others on this machine may hold some, too
        assert len(set(numbers)) == len(numbers) and set(numbers) <= {1, 3, 4, 5}
        if held:
            held[0].close()
            held.append(loopback.reserve_domain())
            assert held[-1].number == numbers[0]
    finally:
        for domain in held:
            domain.close()


@pytest.mark.parametrize(
    ('role', 'topic'), [('exciter', wire.RUN), ('platform', wire.PLATFORM_STATUS)]
)
def test_a_word_that_was_lost_comes_again(lab, role, topic):
    """Who listens late and without history still hears a lead or a follower that waits."""
    node = lab.node(role)
    node.says('waiting for')
    ears = lab.ears(wire.Topic(topic.name, topic.type, topic.depth))
    ears.wait(topic.name, 2)
