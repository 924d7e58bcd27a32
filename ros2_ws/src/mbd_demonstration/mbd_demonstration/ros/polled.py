"""A topic of a thousand messages a second at a small share of a core.

Waking an executor for each message costs ten times what the message itself does; here they are taken together.
"""

from __future__ import annotations

from collections.abc import Callable

from rclpy.callback_groups import CallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import QoSProfile

PERIOD = 0.05  # [s]


class PolledGroup(CallbackGroup):
    """Of subscriptions that no executor waits for."""

    def can_execute(self, entity: object) -> bool:
        """Never by an executor."""
        return False

    def beginning_execution(self, entity: object) -> bool:
        """Never by an executor."""
        return False

    def ending_execution(self, entity: object) -> None:
        """Nothing ends that never began."""


def subscribe_polled(
    node: Node, kind: type[object], topic: str, callback: Callable[[bytes], None], qos: QoSProfile
) -> None:
    """Subscribe to a topic and look every ``PERIOD`` what has come; ``qos`` must keep all that comes till then.

    Args:
        node: whose subscription it is.
        kind: class of the messages.
        topic: its name.
        callback: gets each message's bytes, in order, by the node's executor.
        qos: of the subscription.
    """

    def never(message: object) -> None:
        """No executor waits for it."""

    subscription = node.create_subscription(kind, topic, never, qos, callback_group=PolledGroup())

    def take() -> None:
        with subscription.handle:
            while (taken := subscription.handle.take_message(kind, True)) is not None:
                callback(taken[0])

    node.create_timer(PERIOD, take, clock=Clock(clock_type=ClockType.STEADY_TIME))
