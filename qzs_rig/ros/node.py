"""What the nodes of the rig have in common: lifecycle, parameters, endpoints, diagnostics."""

from __future__ import annotations

import importlib
import math
import time
import traceback
from collections.abc import Callable, Iterable
from typing import Any, TypeAlias

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile

from qzs_rig import wire
from qzs_rig.errors import RigError
from qzs_rig.parameters import Parameter
from qzs_rig.ros import parameters, qos
from qzs_rig.wire import Topic

Message: TypeAlias = Any
"""A message, request, answer or event of rclpy: their classes are generated, or C++."""
Callback = Callable[[Message], object]
ANSWER_S = 1.0
"""How long a node that ends stays after its last answer: the news that it has left travels on
another way, and an answer that comes after it is dropped."""
FLUSH_S = {True: 5.0, False: 0.2}
"""How long a node that ends, after a finished run or not, waits for its messages to arrive: a
listener slower than a run in lockstep would miss the end of it."""
REMIND_S = 5.0
"""How often a node that waits says for what."""
REPEAT_S = 1.0
"""Longest silence of a node that waits: should one word be lost, the next one comes."""
CONFIRM_S = 0.3
"""How long a publisher whose lease ran out may take to show life after all: on a busy machine its
signs come late, and a run must not end for that. With qos.LEASE it stays below a second."""
SUCCESS, FAILURE = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE


class RigNode(LifecycleNode):
    """A lifecycle node that declares its sections of the scenario and ends with an exit code.

    Subclasses fill in `open` (configure), `begin` (activate), `halt` (deactivate), `tick`.
    """

    role = ''
    sections: tuple[str, ...] = ()
    own: tuple[Parameter, ...] = ()
    tick_s = 0.05

    def __init__(self, context: Context | None = None) -> None:
        super().__init__(
            self.role, automatically_declare_parameters_from_overrides=True, context=context
        )
        self.busy = self.active = self.stopped = False
        self.spec = parameters.declare(self, self.sections, self.own)
        parameters.guard(self, self.spec, lambda: self.busy)
        self.exit_code: int | None = None
        self.wake: Callable[[], None] = lambda: None
        self.matched: dict[str, int] = {}
        self._outlets: dict[str, Publisher[Message]] = {}
        self.gone: list[str] = []  # peers that died in a run, in the order of the news
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._diagnostics = self.publisher(wire.DIAGNOSTICS)  # outlives a cleanup
        self.create_timer(1.0, self._diagnose, clock=self._steady)
        self._lasting = self._held()
        self._suspects: dict[str, tuple[float, Callable[[], None]]] = {}
        self._awaited, self._awaited_at = '', 0.0
        self._answered_at = -math.inf

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
        self.spec = parameters.current(self, self.spec)
        self.open()
        self.introduce()
        self.create_timer(self.tick_s, self._tick, clock=self._steady)

    def _clean_up(self) -> None:
        self.close()
        for endpoint, destroy in self._held().items():
            if endpoint not in self._lasting:
                destroy(endpoint)
        self.matched.clear()
        self._outlets.clear()
        self._suspects.clear()

    def _held(self) -> dict[Message, Callback]:
        return {
            **dict.fromkeys(self.timers, self.destroy_timer),
            **dict.fromkeys(self.subscriptions, self.destroy_subscription),
            **dict.fromkeys(self.services, self.destroy_service),
            **dict.fromkeys(self.publishers, self.destroy_publisher),
        }

    def _tick(self) -> None:
        self.answered()
        for label, (until, lost) in list(self._suspects.items()):
            if time.monotonic() > until:
                del self._suspects[label]
                self.attempt(lost)
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

    def flush(self) -> None:
        """Wait until everybody has all messages: what a destroyed publisher still holds is lost."""
        until = time.monotonic() + FLUSH_S[self.exit_code == 0 and not self.stopped]
        for publisher in self.publishers:
            left_s = max(0.0, until - time.monotonic())
            publisher.wait_for_all_acked(Duration(nanoseconds=int(left_s * 1e9)))

    # --- endpoints

    def publisher(self, topic: Topic, profile: QoSProfile | None = None) -> Publisher[Message]:
        """A publisher of serialised messages on `topic`; counts its matches in `matched`."""
        self._outlets[topic.name] = publisher = self.create_publisher(
            message_class(topic.type),
            topic.name,
            profile or qos.reliable(topic),
            event_callbacks=PublisherEventCallbacks(
                matched=self._counter(f'a subscriber of {topic.name}'),
                incompatible_qos=self._misfit(topic.name),
            ),
        )
        return publisher

    def publish(self, topic: Topic, *messages: bytes) -> None:
        """Send serialised messages on `topic`, in their order; nobody hears of a topic that was not
        opened yet."""
        outlet = self._outlets.get(topic.name)
        if outlet is not None:
            send = outlet.publish
            for message in messages:
                send(message)

    def subscribe(
        self,
        topic: Topic,
        callback: Callback,
        profile: QoSProfile | None = None,
        lost: Callable[[], None] | None = None,
        bare: bool = False,
    ) -> None:
        """Raw subscription on `topic`; `lost` is called when its last live publisher dies.

        Its matches are counted in `matched`, unless `lost` is given. A `bare` callback is called as
        it is, thousands of times a second, and must not raise.
        """
        label = f'a publisher of {topic.name}'

        def liveliness(info: Message) -> None:
            assert lost is not None
            if info.alive_count == 0 and (info.alive_count_change or info.not_alive_count_change):
                self._suspects[label] = (time.monotonic() + CONFIRM_S, lost)
            elif info.alive_count:
                self._suspects.pop(label, None)

        def handler(message: Message) -> None:
            self.attempt(lambda: callback(message))

        self.create_subscription(
            message_class(topic.type),
            topic.name,
            callback if bare else handler,  # type: ignore[arg-type]
            profile or qos.reliable(topic),
            raw=True,
            event_callbacks=SubscriptionEventCallbacks(
                # never both of one subscription: rmw_fastrtps takes a match with its own lock held
                # and asks for the reader's, Fast DDS reports liveliness with the reader's held and
                # asks for the other; where they meet, the process stands still for ever
                matched=None if lost else self._counter(label),
                liveliness=liveliness if lost else None,
                incompatible_qos=self._misfit(topic.name),
            ),
        )

    def unmatched(self, labels: Iterable[str]) -> list[str]:
        """Those of "a subscriber of TOPIC" and "a publisher of TOPIC" of which there is none."""
        return [label for label in labels if not self.matched.get(label)]

    def _counter(self, label: str) -> Callable[[Message], None]:
        def count(info: Message) -> None:
            self.matched[label] = info.current_count

        return count

    def _misfit(self, topic: str) -> Callable[[Message], None]:
        def complain(info: Message) -> None:
            self.get_logger().error(qos.misfit(topic, info.last_policy_kind))

        return complain

    def _diagnose(self) -> None:
        stamp = self.get_clock().now().nanoseconds
        self._diagnostics.publish(wire.encode_diagnostics(stamp, self.status()))


def message_class(name: str) -> Message:
    """The generated class of 'package/msg/Type'."""
    package, _, kind = name.split('/')
    return getattr(importlib.import_module(f'{package}.msg'), kind)
