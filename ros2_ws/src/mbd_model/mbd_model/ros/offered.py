"""Subscriptions that ask for what is offered: the topic that has a publisher, as reliable as all of them are.

A stream asked for best effort where its publisher would send it reliably loses every large message of which one
fragment gets lost; asked for reliably where it is offered best effort, it does not come at all.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription

# How often the graph is looked at [s, steady clock].
PERIOD = 0.5


@dataclass(frozen=True)
class StreamSource:
    """A topic that a stream may come by.

    Attributes:
        kind: type of its messages.
        topic: name, before remapping.
    """

    kind: type[Any]
    topic: str


def strongest_qos(offers: Sequence[QoSProfile], depth: int = 1) -> QoSProfile:
    """The strongest profile that all publishers serve; best effort and volatile, which any serves, where there is none.

    Args:
        offers: profiles of the publishers.
        depth: messages to keep for a subscriber that is busy.
    """
    reliable = bool(offers) and all(o.reliability != ReliabilityPolicy.BEST_EFFORT for o in offers)
    latched = reliable and all(o.durability == DurabilityPolicy.TRANSIENT_LOCAL for o in offers)
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


class OfferedSubscription:
    """One stream, by the first of its sources that somebody publishes; subscribed again when that changes.

    Args:
        node: owner of the subscription.
        sources: by preference; the first also while nobody publishes any.
        on_message: called with every message, of any of the sources' types.
        depth: messages to keep while the node is busy.
    """

    def __init__(
        self, node: Node, sources: Sequence[StreamSource], on_message: Callable[[Any], object], depth: int = 1
    ) -> None:
        self._node, self._sources, self._on_message, self._depth = node, tuple(sources), on_message, depth
        self._taken: tuple[StreamSource, QoSProfile] | None = None
        self._subscription: Subscription[Any] | None = None
        self.look()
        steady = rclpy.clock.Clock(clock_type=rclpy.clock.ClockType.STEADY_TIME)
        node.create_timer(PERIOD, self.look, clock=steady)

    @property
    def source(self) -> StreamSource:
        """By what it comes now."""
        return self._sources[0] if self._taken is None else self._taken[0]

    @property
    def reliable(self) -> bool:
        """Whether lost messages are sent again."""
        return self._taken is not None and self._taken[1].reliability == ReliabilityPolicy.RELIABLE

    def look(self) -> None:
        """See what is offered now, and subscribe as that asks for."""
        for source in self._sources:
            offers = [e.qos_profile for e in self._node.get_publishers_info_by_topic(source.topic)]
            if offers:
                self._take(source, strongest_qos(offers, self._depth))
                return
        if self._taken is None:
            self._take(self._sources[0], strongest_qos((), self._depth))

    def _take(self, source: StreamSource, qos: QoSProfile) -> None:
        """Subscribe so, unless it is."""
        if self._taken == (source, qos):
            return
        if self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
        self._taken = source, qos
        self._subscription = self._node.create_subscription(source.kind, source.topic, self._on_message, qos)


def image_sources(
    node: Node, topic: str, raw: type[Any], compressed: type[Any], *, suffixes: Sequence[str], transport: str
) -> tuple[StreamSource, ...]:
    """How an image may come, named as image_transport does: the remapped topic, and that with a suffix.

    Args:
        node: whose remapping rules apply.
        topic: of the raw image.
        raw: type of it, sensor_msgs/Image.
        compressed: type of the others, sensor_msgs/CompressedImage.
        suffixes: of the names of the others, by preference: /compressed, /compressedDepth.
        transport: "raw", "compressed", or "auto": what is offered, raw first.
    """
    resolved = node.resolve_topic_name(topic)
    packed = tuple(StreamSource(compressed, resolved + suffix) for suffix in suffixes)
    plain = (StreamSource(raw, topic),)
    return {"raw": plain, "compressed": packed}.get(transport, plain + packed)
