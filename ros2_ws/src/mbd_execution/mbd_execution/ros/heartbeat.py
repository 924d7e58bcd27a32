"""Whether the arm's driver is alive: its joint states, counted between looks."""

from __future__ import annotations

from mbd_model.ros.conversions import clock_seconds
from mbd_model.ros.qos import SENSOR
from rclpy.node import Node
from sensor_msgs.msg import JointState

LOOKS = 5  # in the time without joint states after which the driver is lost


class Heartbeat:
    """Watches the joint states.

    A node that was held up itself must not take the arm for dead: looks are counted, and messages that waited are taken
    between two looks. Nor must one whose simulated clock stands: nothing is due while it does.

    Args:
        node: who listens.
        topic: of sensor_msgs/JointState; "": nothing is watched.
        silence: [s] without joint states after which the driver is lost.

    Attributes:
        period: [s] between two looks.
    """

    def __init__(self, node: Node, topic: str, silence: float) -> None:
        self._node, self.topic, self._silence = node, topic, silence
        self.period = silence / LOOKS
        self._looks = 0
        self._ever = False
        self._last = 0.0  # [s] of the node's clock
        if topic:
            node.create_subscription(JointState, topic, self._on_joints, SENSOR)

    @property
    def waiting(self) -> bool:
        """Joint states are to come, and none ever did."""
        return bool(self.topic) and not self._ever

    def begin(self) -> None:
        """Count again: a person says that the robot is well."""
        self._looks, self._last = 0, self._now()

    def look(self) -> str:
        """What is wrong, "" for nothing; to be called each ``period``, by a clock that never stands still."""
        if not self.topic or not self._ever:
            return ""
        self._looks += 1
        now = self._now()
        self._last = min(self._last, now)  # a simulation may begin again
        if self._looks <= LOOKS or now - self._last < self._silence:
            return ""
        return f"no joint states on '{self.topic}' for {self._silence:g} s: the arm's driver is lost"

    def _now(self) -> float:
        return clock_seconds(self._node.get_clock())

    def _on_joints(self, _: JointState) -> None:
        self._ever = True
        self.begin()
