"""A driver's fast topic at a small share of a core: messages are taken together, not one by one as they come."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import QoSProfile


class UnwaitedGroup(CallbackGroup):
    """Of subscriptions that no executor waits for: waking it costs ten times what a message does."""

    def can_execute(self, entity: object) -> bool:
        """Never by an executor."""
        return False

    def beginning_execution(self, entity: object) -> bool:
        """Never by an executor."""
        return False

    def ending_execution(self, entity: object) -> None:
        """Nothing ends that never began."""


def subscribe_together(
    node: Node, kind: Any, topic: str, callback: Callable[[Any], None], *, qos: QoSProfile, period: float
) -> None:
    """Subscribe to a topic and look every ``period`` what has come.

    Args:
        node: whose subscription it is.
        kind: type of the messages.
        topic: its name.
        callback: gets each message, in order, by the node's executor.
        qos: of the subscription; its depth is how many are kept from one look to the next.
        period: [s] of the wall clock.
    """

    def never(message: Any) -> None:
        """No executor waits for it."""

    subscription = node.create_subscription(kind, topic, never, qos, callback_group=UnwaitedGroup())

    def take() -> None:
        with subscription.handle:
            while (taken := subscription.handle.take_message(kind, False)) is not None:
                callback(taken[0])

    node.create_timer(period, take, clock=Clock(clock_type=ClockType.STEADY_TIME))
