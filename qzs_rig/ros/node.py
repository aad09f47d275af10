"""What the nodes of the rig have in common: lifecycle, parameters, diagnostics, their end."""

from __future__ import annotations

import math
import time
import traceback
from collections.abc import Callable

from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn

from qzs_rig import scenario, wire
from qzs_rig.errors import InputError, RigError
from qzs_rig.parameters import Parameter, RunSpec, unknown_parameter
from qzs_rig.ros.endpoints import Endpoints, Message

ANSWER_S = 1.0
"""How long a node that ends stays after its last answer: the news that it has left travels on
another way, and an answer that comes after it is dropped."""
REMIND_S = 5.0
"""How often a node that waits says for what."""
REPEAT_S = 1.0
"""Longest silence of a node that waits: should one word be lost, the next one comes."""
SUCCESS, FAILURE = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE

NODE_PARAMETERS = (
    Parameter('autostart', bool, True, '', 'configure and activate without being told'),
    Parameter('exit_when_done', bool, True, '', 'end the process after a run'),
)
"""Parameters of every node that are no part of the scenario."""

OF_ROS = ('use_sim_time', 'start_type_description_service', 'qos_overrides')
OF_SOME_NODE = {'scenario', 'run_id', 'folder', 'peers', 'bag', 'topics', 'pace', 'rate'}
"""Parameters that a node takes no notice of: one file serves all nodes."""


class RigNode(Endpoints):
    """A lifecycle node that declares its sections of the scenario and ends with an exit code.

    Subclasses fill in `open` (configure), `begin` (activate), `halt` (deactivate), `tick`.
    """

    role = ''
    sections: tuple[str, ...] = ()
    own: tuple[Parameter, ...] = ()
    tick_s = 0.05

    def __init__(self, context: Context | None = None) -> None:
        super().__init__(self.role, context)
        self.busy = self.active = self.stopped = False
        self.spec = self._declared()
        self.add_on_set_parameters_callback(self._check)
        self.exit_code: int | None = None
        self.wake: Callable[[], None] = lambda: None
        self.gone: list[str] = []  # peers that died in a run, in the order of the news
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._awaited, self._awaited_at = '', 0.0
        self._answered_at = -math.inf
        self.publisher(wire.DIAGNOSTICS)
        self.create_timer(1.0, self._diagnose, clock=self._steady)
        self.keep_endpoints()

    # --- what a subclass fills in

    def open(self) -> None:
        """Create the endpoints of data; parameters are those of this moment."""

    def introduce(self) -> None:
        """Create the endpoints by which peers hear of this node and of the run, after `open`.

        The middleware tells others of publishers in the order of their creation, and of
        subscriptions in theirs. So whom a node has heard here has all its publishers of data
        matched with this node's subscriptions; once two nodes have heard each other, this holds
        both ways.
        """

    def begin(self) -> None:
        """Start working."""

    def halt(self) -> None:
        """Stop working, softly."""

    def tick(self) -> None:
        """Called every `tick_s` on a steady clock from configure to cleanup: a run that is
        deactivated has to ramp down."""

    def close(self) -> None:
        """Leave nothing half written; called once at the very end, whatever happened."""

    def parted(self) -> bool:
        """The peers have heard how this node ended."""
        return True

    def answer(self, response: Message) -> Message:
        """`response` of a service that may end this node; the executor sends it afterwards."""
        self._answered_at = math.inf
        return response

    def answered(self) -> bool:
        """Whoever called such a service has had ANSWER_S to get its answer, or is gone."""
        if self._answered_at == math.inf:  # the callback has returned, so it is sent by now
            self._answered_at = time.monotonic()
        calm = time.monotonic() - self._answered_at > ANSWER_S
        return calm or not any(self.count_clients(each.service_name) for each in self.services)

    def status(self) -> wire.Status:
        """The node's state for /diagnostics."""
        return wire.Status(self.role, 0, '', {})

    # --- life

    def start(self) -> None:
        """Configure and activate by itself, unless a supervisor wants to (autostart false)."""
        if self.spec.flag('autostart') and self.trigger_configure() == SUCCESS:
            self.trigger_activate()

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        return self._guarded(self._configure)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        if self.busy:
            self.get_logger().error('the last run is still ramping down; activate again after it')
            return FAILURE
        self.active = True
        return self._guarded(self.begin)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.active = False
        return self._guarded(self.halt)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        if self.busy:
            self.get_logger().error('the last run is still ramping down; clean up after it')
            return FAILURE
        return self._guarded(self._clean_up)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.answer(None)
        self.operator_stop('shutdown')
        return SUCCESS

    def _configure(self) -> None:
        self.reread()
        self.open()
        self.introduce()
        self.create_timer(self.tick_s, self._tick, clock=self._steady)

    def _clean_up(self) -> None:
        self.close()
        self.drop_endpoints()

    def _tick(self) -> None:
        self.answered()
        self.report_lost()
        self.attempt(self.tick)

    def _guarded(self, work: Callable[[], None]) -> TransitionCallbackReturn:
        self.answer(None)  # an operator may have called for it
        outcome = None
        try:
            outcome = SUCCESS if self.attempt(work) else FAILURE
        finally:
            if outcome is None:
                traceback.print_exc()  # rclpy would swallow it and leave a dead node
                self.finish(1)
        return outcome

    def remind(self, text: str) -> None:
        """Log what this node waits for: when that changes, and every REMIND_S while it lasts."""
        now = time.monotonic()
        if text != self._awaited or now - self._awaited_at > REMIND_S:
            self._awaited, self._awaited_at = text, now
            self.get_logger().info(text)

    def attempt(self, work: Callable[[], object]) -> bool:
        """Do `work`; a foreseen failure is told to the peers and ends the node with its code."""
        try:
            work()
        except RigError as error:
            self.fail(error)
            return False
        return True

    def fail(self, error: RigError) -> None:
        """Log the reason and end; subclasses tell their peers first."""
        self.get_logger().error(str(error))
        self.finish(error.exit_code)

    def operator_stop(self, why: str) -> None:
        """SIGINT or SIGTERM: close cleanly, at once."""
        self.get_logger().info(f'{why}: closing')
        self.stopped = True
        self.finish(0)

    def finish(self, code: int) -> None:
        """End the process with `code`; the first word counts."""
        if self.exit_code is None:
            self.exit_code = code
            self.wake()

    def _diagnose(self) -> None:
        stamp = self.get_clock().now().nanoseconds
        self.publish(wire.DIAGNOSTICS, wire.encode_diagnostics(stamp, self.status()))

    # --- parameters: names, bounds, units and texts of the one declaration

    def _declared(self) -> RunSpec:
        """Declare the scenario's `sections` and `own` parameters; returns their values.

        Values of other sections are accepted and counted in, since the exciter weighs the payload
        against the shaker's force; unknown names raise InputError.
        """
        table = (*scenario.parameters(), *NODE_PARAMETERS, *self.own)
        given = {}
        for name, override in self.get_parameters_by_prefix('').items():
            if not name.startswith(OF_ROS):
                given[name] = override.value
                self.undeclare_parameter(name)
        names = {p.name for p in table}
        unknown = [name for name in given if name not in names | OF_SOME_NODE]
        if unknown:
            raise InputError(unknown_parameter(unknown[0], [p.name for p in table]))
        spec = RunSpec.of(table, {name: value for name, value in given.items() if name in names})
        for p in table:
            if p.section in self.sections or p in (*NODE_PARAMETERS, *self.own):
                self.declare_parameter(p.name, spec.get(p.name), _descriptor(p))
        return spec

    def reread(self) -> None:
        """Take over into `spec` what was changed since, by `ros2 param set`."""
        changed = {}
        for name in (p.name for p in self.spec.declared if self.has_parameter(p.name)):
            value = self.get_parameter(name).value
            if value is not None and value != self.spec.get(name):
                changed[name] = value
        self.spec = self.spec.override(changed)

    def _check(self, parameters: list[Message]) -> SetParametersResult:
        """Refuse what the declaration does not allow, and everything while a run is on."""
        table = {parameter.name: parameter for parameter in self.spec.declared}
        for name, value in ((p.name, p.value) for p in parameters if p.name in table):
            if self.busy:
                reason = f'{name} is fixed while a run is on; deactivate first'
                return SetParametersResult(successful=False, reason=reason)
            try:
                table[name].convert(value)
            except InputError as error:
                return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)


def _descriptor(parameter: Parameter) -> ParameterDescriptor:
    unit = f' [{parameter.unit}]' if parameter.unit else ''
    return ParameterDescriptor(
        description=f'{parameter.text}{unit}',
        additional_constraints=parameter.range_text,
        # so that integers pass for reals and optional parameters may stay unset
        dynamic_typing=True,
    )
