"""A node's publishers and subscriptions of serialised messages: their quality of service, who is
matched with them, who died."""

from __future__ import annotations

import importlib
import time
from abc import abstractmethod
from collections.abc import Callable, Iterable
from typing import Any, TypeAlias

from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.lifecycle import LifecycleNode
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy

from qzs_rig.wire import Topic

Message: TypeAlias = Any
"""A message, request, answer or event of rclpy: their classes are generated, or C++."""
Callback = Callable[[Message], object]
LEASE = Duration(nanoseconds=500_000_000)
"""A node that has not shown life on a watched topic for this long is dead to its peers."""
CONFIRM_S = 0.3
"""How long a publisher whose lease ran out may take to show life after all: on a busy machine its
signs come late, and a run must not end for that. With LEASE it stays below a second."""


def profile(topic: Topic, *, best_effort: bool = False) -> QoSProfile:
    """Keep last, deep enough for the worst stall, and reliable unless `best_effort`, which suits
    sensor-data drivers. Latched topics serve late joiners; of watched ones the middleware reports
    within LEASE when the publisher dies."""
    quality = QoSProfile(
        reliability=ReliabilityPolicy.BEST_EFFORT if best_effort else ReliabilityPolicy.RELIABLE,
        depth=topic.depth,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if topic.latched else DurabilityPolicy.VOLATILE,
    )
    if topic.watched:
        quality.liveliness = LivelinessPolicy.AUTOMATIC
        quality.liveliness_lease_duration = LEASE
    return quality


class Endpoints(LifecycleNode):
    """A lifecycle node by its endpoints; `matched` counts who is at the other end of each."""

    def __init__(self, name: str, context: Context | None) -> None:
        super().__init__(
            name, automatically_declare_parameters_from_overrides=True, context=context
        )
        self.matched: dict[str, int] = {}
        self._outlets: dict[str, Publisher[Message]] = {}
        self._suspects: dict[str, tuple[float, Callable[[], None]]] = {}
        self._lasting: frozenset[Message] = frozenset()

    @abstractmethod
    def attempt(self, work: Callable[[], object]) -> bool:
        """Do `work`; whether it went well."""

    def publisher(self, topic: Topic) -> None:
        """Open `topic` for serialised messages; its matches are "a subscriber of TOPIC"."""
        self._outlets[topic.name] = self.create_publisher(
            message_class(topic.type),
            topic.name,
            profile(topic),
            event_callbacks=PublisherEventCallbacks(
                matched=self._counter(f'a subscriber of {topic.name}'),
                incompatible_qos=self._misfit(topic.name),
            ),
        )

    def opened(self, topic: Topic) -> bool:
        """Whether `topic` can be published on."""
        return topic.name in self._outlets

    def publish(self, topic: Topic, *messages: bytes) -> None:
        """Send serialised messages on an opened topic, in their order."""
        if topic.name not in self._outlets:
            raise RuntimeError(f'{topic.name} was not opened by publisher()')
        send = self._outlets[topic.name].publish
        for message in messages:
            send(message)

    def subscribe(
        self,
        topic: Topic,
        callback: Callback,
        lost: Callable[[], None] | None = None,
        *,
        best_effort: bool = False,
        bare: bool = False,
    ) -> None:
        """Raw subscription on `topic`; `lost` is called when its last live publisher dies.

        Its matches are counted as "a publisher of TOPIC", unless `lost` is given. A `bare` callback
        is called as it is, thousands of times a second, and must not raise.
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
            profile(topic, best_effort=best_effort),
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

    def report_lost(self) -> None:
        """Call `lost` for those that have shown no life since their lease ran out."""
        for label, (until, lost) in list(self._suspects.items()):
            if time.monotonic() > until:
                del self._suspects[label]
                self.attempt(lost)

    def flush(self, patience_s: float) -> None:
        """Wait until everybody has all messages: what a destroyed publisher still holds is lost."""
        until = time.monotonic() + patience_s
        for publisher in self.publishers:
            left_s = max(0.0, until - time.monotonic())
            publisher.wait_for_all_acked(Duration(nanoseconds=int(left_s * 1e9)))

    def keep_endpoints(self) -> None:
        """What is there now, timers and services included, outlives `drop_endpoints`."""
        self._lasting = frozenset(self._held())

    def drop_endpoints(self) -> None:
        """Destroy all endpoints, timers and services but those that were to be kept."""
        for endpoint, destroy in self._held().items():
            if endpoint not in self._lasting:
                destroy(endpoint)
        kept = set(self.publishers)
        self._outlets = {name: x for name, x in self._outlets.items() if x in kept}
        self.matched.clear()
        self._suspects.clear()

    def _held(self) -> dict[Message, Callback]:
        return {
            **dict.fromkeys(self.timers, self.destroy_timer),
            **dict.fromkeys(self.subscriptions, self.destroy_subscription),
            **dict.fromkeys(self.services, self.destroy_service),
            **dict.fromkeys(self.publishers, self.destroy_publisher),
        }

    def _counter(self, label: str) -> Callable[[Message], None]:
        def count(info: Message) -> None:
            self.matched[label] = info.current_count

        return count

    def _misfit(self, topic: str) -> Callable[[Message], None]:
        def complain(info: Message) -> None:
            policy = getattr(info.last_policy_kind, 'name', info.last_policy_kind)
            self.get_logger().error(
                f'{topic}: the other side offers or asks an incompatible {policy}; '
                'set analyzer.qos to sensor_data for a best-effort driver, or change its QoS'
            )

        return complain


def message_class(name: str) -> Message:
    """The generated class of 'package/msg/Type'."""
    package, _, kind = name.split('/')
    return getattr(importlib.import_module(f'{package}.msg'), kind)
