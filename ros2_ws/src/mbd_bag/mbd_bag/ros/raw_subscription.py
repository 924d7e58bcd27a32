"""A subscription to a topic's bytes that takes several messages at one wake-up."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

_BATCH = 200  # waking an executor costs ten times what a message does; others get their turn all the same


def subscribe_raw(
    node: Node, kind: Any, topic: str, take: Callable[[bytes, dict[str, int]], None], profile: QoSProfile
) -> Subscription[object]:
    """Subscribe to a topic's CDR bytes, with a profile that is made after what its publishers offer.

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

    # What rclpy would log of publishers that offer something else, the caller knows; waiting for these events of sixty
    # topics is half of what each wake-up takes.
    subscription: Subscription[object] = node.create_subscription(
        kind,
        topic,
        receive,
        profile,
        raw=True,
        event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
    )
    return subscription
