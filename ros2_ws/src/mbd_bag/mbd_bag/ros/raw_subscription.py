"""A subscription to a topic's bytes that takes several messages at one wake-up."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

_BATCH = 200  # waking an executor costs ten times what a message does; others get their turn all the same


def subscribe_raw(
    node: Node, kind: Any, topic: str, take: Callable[[bytes, dict[str, int]], None], profile: QoSProfile
) -> Subscription[object]:
    """Subscribe to a topic's CDR bytes.

    Args:
        node: whose subscription it is.
        kind: type of the messages.
        topic: its name.
        take: gets each message's bytes, and what the middleware states of it.
        profile: of the subscription.
    """

    def receive(data: bytes, info: dict[str, int]) -> None:
        take(data, info)
        with subscription.handle:
            for _ in range(_BATCH):
                more = subscription.handle.take_message(kind, True)
                if more is None:
                    return
                take(*more)

    subscription: Subscription[object] = node.create_subscription(kind, topic, receive, profile, raw=True)
    return subscription
