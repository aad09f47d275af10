"""What the middleware reports of matches and deaths must never stop a node."""

from __future__ import annotations

import pytest
import rclpy
from rclpy.event_handler import QoSSubscriptionEventType
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.signals import SignalHandlerOptions

from qzs_rig.ros.analyzer import Analyzer
from qzs_rig.ros.platform import Platform

MATCHED = QoSSubscriptionEventType.RCL_SUBSCRIPTION_MATCHED
LIVELINESS = QoSSubscriptionEventType.RCL_SUBSCRIPTION_LIVELINESS_CHANGED


@pytest.mark.parametrize('kind', [Analyzer, Platform])
def test_no_subscription_asks_for_matches_and_liveliness(lab, kind):
    """rmw_fastrtps and Fast DDS take the two locks behind these in opposite order: a node that
    asked for both stood still for ever, now and then."""
    context = rclpy.Context()
    rclpy.init(
        context=context, domain_id=lab.domain, signal_handler_options=SignalHandlerOptions.NO
    )
    node = kind(context=context)
    try:
        assert node.trigger_configure() == TransitionCallbackReturn.SUCCESS
        asked = [
            {handler.event_type for handler in subscription.event_handlers}
            for subscription in node.subscriptions
        ]
        assert not [types for types in asked if {MATCHED, LIVELINESS} <= types]
        # both are used, by different subscriptions
        assert {MATCHED, LIVELINESS} <= set().union(*asked)
    finally:
        node.destroy_node()
        rclpy.try_shutdown(context=context)
