"""What is on the topics while a run is on: names, types, frames, units, rates."""

from __future__ import annotations

import json
from collections import Counter
from itertools import groupby

import numpy as np
import pytest
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from ros_support import ROLES, SAMPLES, SHORT, Lab

from qzs_rig import wire
from qzs_rig.estimation.estimate import from_document
from qzs_rig.units import DOFS

CONFIGURE, ACTIVATE = (
    ChangeState.Request(transition=Transition(id=number))
    for number in (Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE)
)
DRIVEN = ('vertical', 'horizontal')
SPEC = SHORT | {'excitation.amplitude.horizontal': 0.5}
LIVE = {
    (dof, quantity): wire.live_topic(dof, quantity)
    for dof in DRIVEN
    for quantity in ('frequency_hz', 'transmissibility', 'phase_deg')
}


@pytest.fixture(scope='module')
def heard(tmp_path_factory):
    """Everything that was said during a lockstep run."""
    with Lab(tmp_path_factory.mktemp('topics')) as lab:
        services = (('analyzer/change_state', ChangeState),)
        ears = lab.ears(*wire.TOPICS.values(), *LIVE.values(), services=services)
        exciter, platform = lab.node('exciter', SPEC), lab.node('platform', SPEC)
        # nobody starts before the analyzer is activated, and by then all know these ears
        analyzer = lab.node('analyzer', SPEC, folder=str(lab.folder / 'out'), autostart=False)
        assert ears.call('analyzer/change_state', CONFIGURE).success
        ears.known_to(*ROLES)
        assert ears.call('analyzer/change_state', ACTIVATE).success
        assert [node.code() for node in (exciter, platform, analyzer)] == [0, 0, 0]
        ears.wait('base/imu', SAMPLES)
        ears.wait('top/imu', SAMPLES)
        yield ears


@pytest.mark.parametrize(
    ('topic', 'frame'), [('base/imu', 'base_imu_link'), ('top/imu', 'top_imu_link')]
)
def test_imu(heard, topic, frame):
    messages = heard.messages(topic)
    assert len(messages) == SAMPLES
    assert {m.header.frame_id for m in messages} == {frame}
    assert {m.orientation_covariance[0] for m in messages} == {-1.0}
    sheet = heard.sheets()[-1]
    stamps = np.array([m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in messages])
    assert (stamps == sheet.start_ns + np.arange(SAMPLES) * sheet.step_ns).all()
    # the first sample is taken at rest: specific force +g on the upward axis (REP 145)
    rest = messages[0].linear_acceleration
    assert abs(rest.z - 9.80665) < 1e-12
    assert abs(rest.x) < 1e-12 and rest.y == 0.0


def test_base_motion(heard):
    messages = heard.messages('base/motion')
    sheet = heard.sheets()[-1]
    assert {m.header.frame_id for m in messages} == {'base_plate'}
    assert {tuple(m.joint_names) for m in messages} == {wire.BASE_JOINTS}
    assert {len(m.points) for m in messages[:-1]} == {sheet.chunk}
    assert sum(len(m.points) for m in messages) == SAMPLES
    due = [p.time_from_start.sec * 10**9 + p.time_from_start.nanosec for p in messages[0].points]
    assert due == [k * sheet.step_ns for k in range(sheet.chunk)]
    point = messages[0].points[1]
    assert [len(x) for x in (point.positions, point.velocities, point.accelerations)] == [4, 4, 4]


def test_clock_rises_and_joint_states_are_slow(heard):
    sheet = heard.sheets()[-1]
    clock = [m.clock.sec * 10**9 + m.clock.nanosec for m in heard.messages('/clock')]
    assert clock == sorted(set(clock))
    assert clock[-1] == sheet.start_ns + (SAMPLES - 1) * sheet.step_ns
    states = heard.messages('joint_states')
    assert {tuple(m.name) for m in states} == {wire.BASE_JOINTS + wire.TOP_JOINTS}
    assert {len(m.position) for m in states} == {len(m.velocity) for m in states} == {8}
    # a run in lockstep gives a chunk at least every 40 samples, far more often than 60 Hz
    assert 1 <= len(states) < len(clock)


def test_sheets_come_in_order(heard):
    sheets = heard.sheets()
    # a lead that waits says its sheet again and again
    states = [state for state, _ in groupby(sheet.state for sheet in sheets)]
    assert states == ['waiting', 'armed', 'running', 'finished']
    assert len({s.run_id for s in sheets}) == 1
    assert sheets[-1].spec['excitation.amplitude.vertical'] == 1.0
    assert {name.split('.')[0] for name in sheets[-1].spec} >= {
        'run', 'excitation', 'platform', 'sensor', 'analyzer',
    }  # fmt: skip


def test_live_values_and_estimate(heard):
    for (dof, quantity), topic in LIVE.items():
        values = [m.data for m in heard.messages(topic.name)]
        assert values and np.isfinite(values).all(), (dof, quantity)
    heard_hz = [m.data for m in heard.messages('analyzer/vertical/frequency_hz')]
    assert min(heard_hz) > 1.9 and max(heard_hz) < 6.1
    last = from_document(json.loads(heard.messages('analyzer/estimate')[-1].data))
    assert {curve.dof for curve in last.curves} == set(DRIVEN)


def test_every_node_reports_its_health(heard):
    statuses = [s for m in heard.messages('/diagnostics') for s in m.status]
    assert {s.hardware_id for s in statuses} == {'qzs_rig'}
    assert {s.name for s in statuses} >= {'exciter', 'platform'}
    kinds = Counter(type(s.level) for s in statuses)
    assert set(kinds) == {bytes}


def test_no_other_degree_of_freedom_is_published(heard):
    names = {name for name, _ in heard.node.get_topic_names_and_types()}
    others = set(DOFS) - set(DRIVEN)
    assert not [name for name in names for dof in others if f'/analyzer/{dof}/' in name]
