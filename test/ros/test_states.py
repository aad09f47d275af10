"""The steps between the states of leader and followers, and a follower's status on the wire."""

from __future__ import annotations

import pytest
import rclpy
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.signals import SignalHandlerOptions

from qzs_rig import wire
from qzs_rig.errors import InputError
from qzs_rig.parameters import Parameter
from qzs_rig.ros.node import RigNode
from qzs_rig.ros.states import NEXT, FollowerState, FollowerStatus, LeadState, from_wire, stepped


@pytest.mark.parametrize('kind', [LeadState, FollowerState])
def test_every_state_can_be_reached(kind):
    reached, new = set(), {kind.UNCONFIGURED}
    while new:
        reached |= new
        new = set().union(*(NEXT[state] for state in new)) - reached
    assert reached == set(kind)


@pytest.mark.parametrize(
    ('now', 'then'),
    [
        (LeadState.WAITING, LeadState.RUNNING),
        (LeadState.ENDED, LeadState.ARMED),
        (FollowerState.WAITING, FollowerState.ARMED),
        (FollowerState.DONE, FollowerState.RUNNING),
    ],
)
def test_a_step_that_is_not_in_the_table_is_refused(now, then):
    with pytest.raises(RuntimeError, match=f'{then} cannot follow {now}'):
        stepped(now, then)


def test_a_status_survives_the_wire():
    spec = {'sensor.rate_noise': 1e-3, 'platform.law': 'cubic'}
    status = FollowerStatus('platform', FollowerState.READY, 0, 'ready', 'abc', 7, spec)
    assert from_wire(wire.decode_status(wire.encode_status(status.to_wire()))) == status


@pytest.mark.parametrize(
    'damage', [{'state': 'asleep'}, {'index': 'many'}, {'spec': '{'}], ids=lambda d: next(iter(d))
)
def test_a_status_of_something_else_is_refused(damage):
    values = {'state': 'ready', 'index': '3'} | damage
    with pytest.raises(InputError, match='platform/status is none of a follower'):
        from_wire(wire.Status('platform', 0, '', values))


class Thermometer(RigNode):
    """A node as the recipe of ARCHITECTURE.md has it."""

    role = 'thermometer'
    sections = ('sensor',)
    own = (Parameter('celsius', float, 20.0, 'degC', 'what it reads', -50.0, 100.0),)

    def open(self):
        self.publisher(TEMPERATURE)

    def tick(self):
        if self.active:
            self.publish(TEMPERATURE, wire.encode_float(self.spec.number('celsius')))


TEMPERATURE = wire.Topic('room/celsius', 'std_msgs/msg/Float64', 10)


def test_a_node_after_the_recipe(lab):
    """It has parameters, life, diagnostics and topics by that alone."""
    ears = lab.ears(TEMPERATURE)
    context = rclpy.Context()
    rclpy.init(
        context=context, domain_id=lab.domain, signal_handler_options=SignalHandlerOptions.NO
    )
    executor = rclpy.executors.SingleThreadedExecutor(context=context)
    node = Thermometer(context=context)
    try:
        executor.add_node(node)
        with pytest.raises(RuntimeError, match='room/celsius was not opened'):
            node.publish(TEMPERATURE, wire.encode_float(20.0))
        node.start()
        for _ in range(400):
            executor.spin_once(timeout_sec=0.05)
            if ears.got['room/celsius']:
                break
        assert ears.got['room/celsius'][0] == wire.encode_float(20.0)
        assert node.get_parameter('celsius').value == 20.0 and node.has_parameter('sensor.kind')
        assert node.trigger_deactivate() == TransitionCallbackReturn.SUCCESS
        assert node.trigger_cleanup() == TransitionCallbackReturn.SUCCESS
    finally:
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown(context=context)
