"""A driver's word of its robot's safety in the cell, and a button that stops the robot there."""

from __future__ import annotations

from typing import Any

from mbd_model.ros.qos import LATCHED
from mbd_robot.profiles.robot import RobotProfile
from mbd_robot.profiles.safety import SafetyTopic
from mbd_robot.ros.interfaces import interface
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from std_srvs.srv import SetBool

BUTTON = "cell/robot_stop"
PERIOD_NS = 50_000_000  # simulated time between two words of a driver that says it all the time


class StandInSafety:
    """Plays a profile's safety topics, and Kinova's services to stop and to start.

    ``cell/robot_stop`` (std_srvs/SetBool) presses the robot's stop and lets it go: each topic then states the first of
    its stops.

    Args:
        node: the server's.
        profile: of the robot.
    """

    def __init__(self, node: Node, profile: RobotProfile) -> None:
        self._pressed = False
        self._stopped = False  # by Kinova's in/stop
        self._due = 0
        self._topics: list[tuple[SafetyTopic, Any, Publisher[Any]]] = []
        for topic in profile.safety:
            kind = interface(*topic.type.split("/"))
            quality = LATCHED if topic.latched else QoSProfile(depth=1)
            self._topics.append((topic, kind, node.create_publisher(kind, topic.topic, quality)))
        self._publish(latched=True)
        node.create_service(SetBool, BUTTON, self._on_button)
        if profile.arm.stop_service:
            stop, start = (interface("kinova_msgs", "srv", name) for name in ("Stop", "Start"))
            node.create_service(stop, profile.arm.stop_service, self._on_stop)
            node.create_service(start, profile.arm.start_service, self._on_start)

    @property
    def stands(self) -> bool:
        """The robot takes no goal, and gives up the one under way."""
        return self._pressed or self._stopped

    @property
    def refuses(self) -> bool:
        """Goals are refused; a stopped Kinova takes them and gives them up at once."""
        return self._pressed

    def publish(self, time_ns: int) -> None:
        """What the driver says all the time; simulated time [ns]."""
        if time_ns >= self._due:
            self._due = time_ns + PERIOD_NS
            self._publish(latched=False)

    def _publish(self, *, latched: bool) -> None:
        for topic, kind, publisher in self._topics:
            if topic.latched is not latched:
                continue
            msg = kind()
            *path, field = topic.field.split(".")
            inner = msg
            for name in path:
                inner = getattr(inner, name)
            value = topic.stops[0].value if self._pressed else topic.well
            setattr(inner, field, bool(value) if isinstance(getattr(inner, field), bool) else value)
            publisher.publish(msg)

    def _on_button(self, request: SetBool.Request, answer: SetBool.Response) -> SetBool.Response:
        self._pressed = bool(request.data)
        self._publish(latched=True)
        self._publish(latched=False)
        answer.success, answer.message = True, "the robot stands" if self._pressed else "the robot may move"
        return answer

    def _on_stop(self, _: Any, answer: Any) -> Any:
        self._stopped, answer.stop_result = True, "Arm stopped"
        return answer

    def _on_start(self, _: Any, answer: Any) -> Any:
        self._stopped, answer.start_result = False, "Arm started"
        return answer
