"""Sends hostile messages to every topic and service that somebody of a session listens to."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from rclpy.client import Client
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile

from mbd_bringup.ros.hostile_messages import hostile_message, message_class

_SEND_GOAL = "_action/send_goal"
# Of rclpy's own, in C: what they do is not ours to try.
_NOT_OURS = ("/get_type_description",)


def _offered(asked: QoSProfile) -> QoSProfile:
    """What serves a subscription; the network does not report its history."""
    return QoSProfile(depth=10, reliability=asked.reliability, durability=asked.durability)


@dataclass
class HostileSender:
    """Publishes and calls, from a node of its own.

    Attributes:
        node: that sends.
        rng: decides what.
        sent: how many messages and requests went out, by topic or service.
    """

    node: Node
    rng: np.random.Generator
    sent: dict[str, int] = field(default_factory=dict)
    _publishers: dict[str, tuple[Any, Publisher[Any]]] = field(default_factory=dict)
    _clients: dict[str, tuple[Any, Client[Any, Any]]] = field(default_factory=dict)

    def look(self, nodes: set[str]) -> None:
        """Find what these nodes listen to."""
        for topic, types in self.node.get_topic_names_and_types():
            infos = [i for i in self.node.get_subscriptions_info_by_topic(topic) if i.node_name in nodes]
            if infos and topic not in self._publishers and topic != "/clock" and "/msg/" in types[0]:
                kind = message_class(types[0])
                self._publishers[topic] = kind, self.node.create_publisher(kind, topic, _offered(infos[0].qos_profile))
        for name in nodes:
            for service, types in self.node.get_service_names_and_types_by_node(name, "/"):
                if service not in self._clients and not service.endswith(_NOT_OURS):
                    kind = self._service(types[0])
                    if kind is not None:
                        self._clients[service] = kind, self.node.create_client(kind, service)

    @staticmethod
    def _service(name: str) -> Any:
        package, kind, short = name.split("/")
        if kind == "srv":
            return message_class(name)
        if not short.endswith("_SendGoal"):
            return None  # the others carry ids that the server itself gave out
        return message_class(f"{package}/action/{short.removesuffix('_SendGoal')}").Impl.SendGoalService

    @property
    def places(self) -> tuple[str, ...]:
        """Every topic and service found."""
        return (*self._publishers, *self._clients)

    def send(self, place: str) -> None:
        """Send one message or request there."""
        if place in self._publishers:
            kind, publisher = self._publishers[place]
            publisher.publish(hostile_message(kind, self.rng))
        else:
            kind, client = self._clients[place]
            if not client.service_is_ready():
                return
            client.call_async(hostile_message(kind.Request, self.rng))
        self.sent[place] = self.sent.get(place, 0) + 1

    def rounds(self, number: int) -> Iterator[int]:
        """Send to every place in turn until so many were sent; gives that number after each round."""
        while (total := sum(self.sent.values())) < number:
            for place in self.rng.permutation(self.places):
                self.send(str(place))
            if total == sum(self.sent.values()):
                return
            yield sum(self.sent.values())
