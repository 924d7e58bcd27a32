"""A topic of a thousand messages a second at a small share of a core.

Waking an executor for each message costs ten times what the message itself does; here they are taken together.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription


class UnwaitedGroup(CallbackGroup):
    """Of subscriptions that no executor waits for."""

    def can_execute(self, entity: object) -> bool:
        """Never by an executor."""
        return False

    def beginning_execution(self, entity: object) -> bool:
        """Never by an executor."""
        return False

    def ending_execution(self, entity: object) -> None:
        """Nothing ends that never began."""


def taken(subscription: Subscription[Any], kind: Any, *, raw: bool = False) -> Iterator[Any]:
    """What has come for a subscription of an ``UnwaitedGroup``, in order.

    Args:
        subscription: whose messages they are.
        kind: type of the messages.
        raw: their bytes instead.
    """
    with subscription.handle:
        while (message := subscription.handle.take_message(kind, raw)) is not None:
            yield message[0]


def subscribe_polled(
    node: Node,
    kind: Any,
    topic: str,
    callback: Callable[[Any], None],
    *,
    qos: QoSProfile,
    period: float,
    raw: bool = False,
) -> None:
    """Subscribe to a topic and look every ``period`` what has come.

    Args:
        node: whose subscription it is.
        kind: type of the messages.
        topic: its name.
        callback: gets each message, in order, by the node's executor.
        qos: of the subscription; its depth is how many are kept from one look to the next.
        period: [s] of the wall clock.
        raw: give the callback each message's bytes instead.
    """

    def never(message: Any) -> None:
        """No executor waits for it."""

    subscription = node.create_subscription(kind, topic, never, qos, callback_group=UnwaitedGroup())

    def take() -> None:
        for message in taken(subscription, kind, raw=raw):
            callback(message)

    node.create_timer(period, take, clock=Clock(clock_type=ClockType.STEADY_TIME))
