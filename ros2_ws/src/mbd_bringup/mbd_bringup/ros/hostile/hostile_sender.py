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
from unique_identifier_msgs.msg import UUID

from mbd_bringup.ros.hostile.hostile_messages import hostile_message, message_class

# Of an action, by the ends of their types' names: its services, and what it says meanwhile.
_OF_ACTIONS = {"_SendGoal": "SendGoalService", "_GetResult": "GetResultService", "_FeedbackMessage": "FeedbackMessage"}
# Of rclpy's own, in C: what they do is not ours to try.
_NOT_OURS = ("/get_type_description",)


def _offered(asked: QoSProfile) -> QoSProfile:
    """What serves a subscription; the network does not report its history."""
    return QoSProfile(depth=10, reliability=asked.reliability, durability=asked.durability)


def _class_of(name: str) -> Any:
    """The class of a topic's or service's type, as the graph names it; None for a type that is no message's."""
    package, kind, short = name.split("/")
    if kind != "action":
        return message_class(name)
    for ending, inner in _OF_ACTIONS.items():
        if short.endswith(ending):
            return getattr(message_class(f"{package}/action/{short.removesuffix(ending)}").Impl, inner)
    return None


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
    _goals: list[Any] = field(default_factory=list)  # their ids
    _clients: dict[str, tuple[Any, Client[Any, Any]]] = field(default_factory=dict)

    def look(self, nodes: set[str]) -> None:
        """Find what these nodes listen to."""
        for topic, types in self.node.get_topic_names_and_types():
            infos = [i for i in self.node.get_subscriptions_info_by_topic(topic) if i.node_name in nodes]
            if infos and topic not in self._publishers and topic != "/clock":
                kind = _class_of(types[0])
                if kind is not None:
                    publisher = self.node.create_publisher(kind, topic, _offered(infos[0].qos_profile))
                    self._publishers[topic] = kind, publisher
        for name in nodes:
            for service, types in self.node.get_service_names_and_types_by_node(name, "/"):
                if service not in self._clients and not service.endswith(_NOT_OURS):
                    kind = _class_of(types[0])
                    if kind is not None:
                        self._clients[service] = kind, self.node.create_client(kind, service)

    @property
    def places(self) -> tuple[str, ...]:
        """Every topic and service found."""
        return (*self._publishers, *self._clients)

    def send(self, place: str) -> None:
        """Send one message or request there."""
        if place in self._publishers:
            kind, publisher = self._publishers[place]
            publisher.publish(self._made(kind))
        else:
            kind, client = self._clients[place]
            if not client.service_is_ready():
                return
            client.call_async(self._made(kind.Request))
        self.sent[place] = self.sent.get(place, 0) + 1

    def _made(self, kind: Any) -> Any:
        """A message or request; every other one that names a goal names one that was sent before."""
        made = hostile_message(kind, self.rng)
        named = made.goal_info if hasattr(made, "goal_info") else made
        if isinstance(getattr(named, "goal_id", None), UUID):
            if self._goals and self.rng.random() < 0.5:
                named.goal_id = UUID(uuid=self._goals[int(self.rng.integers(len(self._goals)))])
            elif hasattr(named, "goal"):
                self._goals.append(np.array(named.goal_id.uuid, dtype=np.uint8))
        return made

    def rounds(self, number: int) -> Iterator[int]:
        """Send to every place in turn until so many were sent; gives that number after each round."""
        while (total := sum(self.sent.values())) < number:
            for place in self.rng.permutation(self.places):
                self.send(str(place))
            if total == sum(self.sent.values()):
                return
            yield sum(self.sent.values())
