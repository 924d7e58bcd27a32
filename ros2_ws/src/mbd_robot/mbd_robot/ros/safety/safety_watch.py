"""The driver's own word of its robot's safety, latched as the suite's stop."""

from __future__ import annotations

from functools import partial, reduce
from typing import Any

from mbd_model.errors import MbdError
from mbd_model.ros.polling.subscriptions import subscribe_polled
from mbd_model.ros.qos import LATCHED
from mbd_model.ros.stop_line import StopLine
from mbd_model.stop import StopCause
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

from mbd_robot.profiles.safety import SafetyCause, SafetyStop, SafetyTopic
from mbd_robot.ros.interfaces import interface

NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
PERIOD = 0.05  # [s] between two looks at a state that comes up to a thousand times a second
CAUSES = {
    SafetyCause.EMERGENCY_STOP: StopCause.EMERGENCY_STOP,
    SafetyCause.PROTECTIVE_STOP: StopCause.PROTECTIVE_STOP,
}


class SafetyWatch:
    """Listens to a profile's safety topics.

    A stop is said as soon as it is received, and again after a person has resumed while the robot still stands: nothing
    moves before the driver says so too.

    Args:
        node: that listens.
        title: of the robot, for people.
        topics: of its profile.
        line: that stops the suite.

    Raises:
        MbdError: a message package is not installed, or a message has no such field.
    """

    def __init__(self, node: Node, title: str, topics: tuple[SafetyTopic, ...], line: StopLine) -> None:
        self._title, self._line = title, line
        self._standing: dict[str, SafetyStop] = {}
        for topic in topics:
            package, kind, name = topic.type.split("/")
            message = interface(package, kind, name)
            try:
                _value(message(), topic.field)
            except AttributeError as error:
                fields = ", ".join(message.get_fields_and_field_types())
                raise MbdError(f"{topic.type} has no field '{topic.field}'; it has {fields}") from error
            take = partial(self._on_state, topic)
            if topic.latched:
                node.create_subscription(message, topic.topic, take, LATCHED)
            else:
                subscribe_polled(node, message, topic.topic, take, qos=NEWEST, period=PERIOD)

    @property
    def why(self) -> str:
        """Why the driver lets nothing move, "" when it does."""
        return "; ".join(f"{self._title}: {stop.says}" for stop in self._standing.values())

    def look(self) -> None:
        """Say it again where a person has resumed too early; to be called now and then."""
        for stop in self._standing.values():
            self._line.stop(CAUSES[stop.cause], f"{self._title}: {stop.says}")

    def _on_state(self, topic: SafetyTopic, msg: Any) -> None:
        stop = topic.stop_at(int(_value(msg, topic.field)))
        if stop is None:
            self._standing.pop(topic.topic, None)
        elif self._standing.get(topic.topic) != stop:
            self._standing[topic.topic] = stop
            self._line.stop(CAUSES[stop.cause], f"{self._title}: {stop.says}")


def _value(msg: Any, field: str) -> Any:
    return reduce(getattr, field.split("."), msg)
