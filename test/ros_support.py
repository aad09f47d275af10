"""Real nodes in processes of their own, and ears on their topics, for tests over ROS 2."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
import rclpy  # a plain import: without ROS these tests fail, they do not skip
from lifecycle_msgs.srv import GetState
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from qzs_rig import loopback, scenario, wire
from qzs_rig.bag import BagReader
from qzs_rig.ros.endpoints import message_class, profile
from qzs_rig.run import in_process
from qzs_rig.run.sheet import from_document

# for the ears, as a node does it for itself
os.environ[loopback.RANGE] = 'LOCALHOST'
loopback.settle(os.environ)

ROOT = Path(__file__).resolve().parent.parent
PATIENCE_S = 30.0
"""How long a test waits for what must come: long enough for a machine that is busy elsewhere."""
ROLES = ('exciter', 'platform', 'analyzer')
SHORT = {
    'excitation.duration': 8.0,
    'excitation.ramp': 1.0,
    'excitation.frequency_low': 2.0,
    'excitation.frequency_high': 6.0,
    'excitation.amplitude.vertical': 1.0,
    'run.rate': 200.0,
}
"""Ten seconds of rig time in 2001 samples."""
SAMPLES = 2001
LONG = SHORT | {'excitation.duration': 600.0, 'run.mode': 'real_time'}
"""A run that lasts longer than any test."""


def environment(domain):
    """What a user's shell would hold, on this machine alone and in a domain of its own."""
    # the profile is what this process has settled on; a node settles by itself
    shell = {name: value for name, value in os.environ.items() if '_DEFAULT_PROFILES' not in name}
    return shell | {
        loopback.RANGE: 'LOCALHOST',
        loopback.DOMAIN: str(domain),
        'ROS_PYTHON_CHECK_FIELDS': '1',
        'PYTHONUNBUFFERED': '1',
        'PYTHONPATH': os.pathsep.join(
            [str(ROOT), *filter(None, [os.environ.get('PYTHONPATH', '')])]
        ),
    }


def wait_until(condition, what, patience_s=PATIENCE_S):
    """The first true value of `condition()`; fails with `what` after the patience is used up."""
    until = time.monotonic() + patience_s
    while time.monotonic() < until:
        value = condition()
        if value:
            return value
        time.sleep(0.005)
    value = condition()
    assert value, f'{what()} after {patience_s} s' if callable(what) else f'{what}: not in time'
    return value


class Process:
    """A process with its output in files; `ended_at` is on the monotonic clock."""

    def __init__(self, name, command, env, folder, cwd=None):
        self.name = name
        number = len(list(folder.glob('*.out')))
        self._out = folder / f'{number}_{name}.out'
        self._err = folder / f'{number}_{name}.err'
        with self._out.open('wb') as out, self._err.open('wb') as err:
            self._process = subprocess.Popen(
                command, stdout=out, stderr=err, stdin=subprocess.DEVNULL, env=env, cwd=cwd,
                start_new_session=True,
            )  # fmt: skip
        self.pid = self._process.pid
        self.ended_at = None
        self._watcher = threading.Thread(target=self._watch, daemon=True)
        self._watcher.start()

    def _watch(self):
        self._process.wait()
        self.ended_at = time.monotonic()

    @property
    def log(self):
        return self._err.read_text(errors='replace')

    @property
    def out(self):
        return self._out.read_text(errors='replace')

    @property
    def running(self):
        return self.ended_at is None

    def says(self, text, patience_s=PATIENCE_S):
        """Wait until `text` is in the log."""
        wait_until(
            lambda: text in self.log or (not self.running and text in self.log),
            lambda: f'{self.name} never said {text!r}; it said:\n{self.log}',
            patience_s,
        )

    def code(self, patience_s=PATIENCE_S):
        """Exit code, waited for."""
        wait_until(
            lambda: not self.running,
            lambda: f'{self.name} still runs; it said:\n{self.log}',
            patience_s,
        )
        return self._process.returncode

    def signal(self, number):
        """Send a signal; returns when, on the monotonic clock."""
        self._process.send_signal(number)
        return time.monotonic()

    def end(self):
        """Whatever happened: no process is left."""
        if self.running:
            self._process.send_signal(signal.SIGCONT)
            self._process.kill()
        self._watcher.join()


class Ears:
    """A node in the test's own process: keeps what comes on topics, calls services, publishes."""

    def __init__(self, domain, topics=(), services=(), publishers=(), namespace=''):
        self.context = rclpy.Context()
        rclpy.init(
            context=self.context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO
        )
        self.node = rclpy.create_node('ears', context=self.context, namespace=namespace)
        self.got = {topic.name: [] for topic in topics}
        self._types = {topic.name: message_class(topic.type) for topic in topics}
        self._subscriptions = {topic.name: self._subscribe(topic) for topic in topics}
        self._clients = {name: self.node.create_client(kind, name) for name, kind in services}
        self.publish = {
            topic.name: self.node.create_publisher(
                message_class(topic.type),
                topic.name,
                profile(topic) if topic.watched else _profile(topic),
            )
            for topic in publishers
        }
        # the last of all endpoints; see `known_to`
        self._probes = {
            role: self.node.create_client(GetState, f'{role}/get_state') for role in ROLES
        }
        self._end = Future()
        self._thread = threading.Thread(target=self._spin, daemon=True)
        self._thread.start()

    def _subscribe(self, topic):
        keep = self.got[topic.name].append
        return self.node.create_subscription(
            message_class(topic.type), topic.name, lambda raw: keep(bytes(raw)),
            _profile(topic), raw=True,
        )  # fmt: skip

    def _spin(self):
        from rclpy.experimental import EventsExecutor

        executor = EventsExecutor(context=self.context)
        executor.add_node(self.node)
        while not self._end.done():
            executor.spin_until_future_complete(self._end, timeout_sec=0.05)

    def messages(self, name):
        """All messages so far, deserialised by ROS itself."""
        return [deserialize_message(raw, self._types[name]) for raw in list(self.got[name])]

    def sheets(self):
        """The run sheets so far."""
        return [from_document(wire.decode_json(raw)) for raw in list(self.got['rig/run'])]

    def known_to(self, *roles):
        """Wait until these nodes have matched every endpoint of these ears.

        The middleware announces endpoints in the order of their creation, so the answer to the
        client that was made last is the proof. An answer is lost while its reader is unknown;
        asking once more is harmless.
        """
        for role in roles:
            probe, asked = self._probes[role], []
            wait_until(probe.service_is_ready, f'service {role}/get_state')

            def answered(probe=probe, asked=asked):
                if not asked or time.monotonic() - asked[-1][0] > 1.0:
                    asked.append((time.monotonic(), probe.call_async(GetState.Request())))
                return any(future.done() for _, future in asked)

            wait_until(answered, f'an answer of {role}/get_state')

    def wait(self, name, count=1):
        """Wait for `count` messages."""
        wait_until(
            lambda: len(self.got[name]) >= count,
            lambda: f'{len(self.got[name])} of {count} messages on {name}',
        )
        return self.got[name]

    def call(self, name, request=None):
        """The answer of a node's service: asked once, when the node can answer."""
        client = self._clients[name]
        self.known_to(name.split('/')[0])
        wait_until(client.service_is_ready, f'service {name}')
        future = client.call_async(request or client.srv_type.Request())
        wait_until(future.done, f'an answer of {name}')
        return future.result()

    def close(self):
        self._end.set_result(None)
        self._thread.join(5.0)
        self.node.destroy_node()
        rclpy.try_shutdown(context=self.context)


class Lab:
    """One test's domain, folder, processes and ears; everything ends with it."""

    def __init__(self, folder):
        self.folder = folder
        self._reserved = loopback.reserve_domain()
        self.domain = self._reserved.number
        self.env = environment(self.domain)
        self.prefix = ()
        self.processes = []
        self._ears = []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for process in self.processes:
            process.end()
        for ears in self._ears:
            ears.close()
        self._reserved.close()

    def run(self, name, command, **more):
        """Start any process."""
        self.folder.mkdir(parents=True, exist_ok=True)
        process = Process(name, [*self.prefix, *command], self.env, self.folder, **more)
        self.processes.append(process)
        return process

    def node(self, role, parameters=SHORT, arguments=(), **own):
        """Start a node as `ros2 run` would."""
        given = [f'{name}:={_word(value)}' for name, value in {**parameters, **own}.items()]
        words = [word for text in given for word in ('-p', text)]
        command = [sys.executable, '-m', f'qzs_rig.ros.{role}', '--ros-args', *words, *arguments]
        return self.run(role, command)

    def rig(self, parameters=SHORT, order=('analyzer', 'platform', 'exciter'), out='out'):
        """The three nodes of a run that is kept in `folder/out`."""
        own = {'analyzer': {'folder': str(self.folder / out)}}
        nodes = {role: self.node(role, parameters, **own.get(role, {})) for role in order}
        return [nodes[role] for role in ROLES]

    def cli(self, *words, **more):
        """Start `qzs-rig WORDS`."""
        return self.run('qzs-rig', [sys.executable, '-m', 'qzs_rig.cli.main', *words], **more)

    def ears(self, *topics, **more):
        """Ears in this domain."""
        self._ears.append(Ears(self.domain, topics, **more))
        return self._ears[-1]


@pytest.fixture
def lab(tmp_path):
    """A lab of the test's own."""
    with Lab(tmp_path) as lab:
        yield lab


def given(parameters):
    """--set words of `parameters`."""
    return [word for name, value in parameters.items() for word in ('--set', f'{name}={value}')]


def document(path):
    """A JSON file."""
    return json.loads(path.read_text())


def kept(folder):
    """run.json and estimate.json of a run."""
    return document(folder / 'run.json'), document(folder / 'estimate.json')


def without_ros(parameters):
    """The same run without ROS: estimate document, and what the bag must hold (n, 12|6|6)."""
    pieces = []
    result = in_process.run(
        scenario.of(parameters), 0,
        tap=lambda base, out: pieces.append((base.data, out.base_imu.data, out.top_imu.data)),
    )  # fmt: skip
    columns = [np.concatenate(column) for column in zip(*pieces, strict=True)]
    return json.loads(result.estimate.to_json()), columns


def read(bag):
    """The bag's sheets, base motion (n, 12) with stamps, and both Imu streams."""
    reader = BagReader(bag)
    try:
        sheets = [from_document(sheet) for sheet in reader.run_sheets()]
        rows = reader.rows('base/motion', wire.BASE_MOTION.type).messages()
        imus = [
            wire.decode_imu(reader.rows(name, wire.BASE_IMU.type).messages())
            for name in ('base/imu', 'top/imu')
        ]
    finally:
        reader.close()
    chunks = [wire.decode_motion(raw) for raw in rows]
    return sheets, chunks, imus


def same_bits(a, b):
    """Equal shape and equal bytes: -0.0 and NaN count."""
    return a.shape == b.shape and a.tobytes() == b.tobytes()


def _profile(topic):
    late = DurabilityPolicy.TRANSIENT_LOCAL if topic.latched else DurabilityPolicy.VOLATILE
    return QoSProfile(
        depth=20000,
        history=HistoryPolicy.KEEP_LAST,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=late,
    )


def _word(value):
    return str(value).lower() if isinstance(value, bool) else json.dumps(value)
