"""Simulated time passes no faster than the node that reads the driver can follow."""

from __future__ import annotations

import time

from mbd_model.ros.conversions import stamp_from_msg
from mbd_model.ros.qos import SENSOR
from mbd_robot.topics import JOINT_STATE
from rclpy.node import Node
from sensor_msgs.msg import JointState

LEAD_NS = 300_000_000  # simulated time by which the cell may be ahead of what was passed on
PATIENCE = 1.0  # [s, wall clock] until a node that passes nothing on is not waited for any more


class Pace:
    """Receives what the robot node passes on.

    A real second is a second for everybody. A simulated one takes a few hundredths, and on a busy machine the robot
    node is held up for longer than that: it would pass on an arm that leaps by seconds, and plan from where it was.

    Args:
        node: the cell's.
    """

    def __init__(self, node: Node) -> None:
        self._stamp: int | None = None
        self._received_at = 0.0
        node.create_subscription(JointState, JOINT_STATE, self._on_joints, SENSOR)

    def ahead(self, time_ns: int) -> bool:
        """Whether simulated time [ns] is to stand still for a moment."""
        if self._stamp is None or time.monotonic() - self._received_at > PATIENCE:
            return False
        return time_ns - self._stamp > LEAD_NS

    def _on_joints(self, msg: JointState) -> None:
        self._stamp, self._received_at = stamp_from_msg(msg.header.stamp), time.monotonic()
