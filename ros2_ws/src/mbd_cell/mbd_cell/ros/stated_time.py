"""The simulation's time on /clock, also while it stands."""

from __future__ import annotations

import math

from mbd_model.ros.conversions import stamp_to_msg
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock

PERIOD = 0.1  # [s, wall clock] after which the time is stated again while it stands


class StatedTime:
    """States the time whenever it has passed, and again now and then while it stands.

    What somebody else's message on /clock did to the clocks of others, were it only one, would else last until the time
    passes again; and that may depend on a node that takes its clock for one that goes.

    Args:
        node: the cell's.
    """

    def __init__(self, node: Node) -> None:
        self._publisher = node.create_publisher(Clock, "/clock", QoSProfile(depth=10))
        self._stated, self._stated_at = -1, -math.inf

    def state(self, time_ns: int, now: float) -> None:
        """Publish the time, if it is due.

        Args:
            time_ns: of the simulation [ns].
            now: by a clock that never stands still [s].
        """
        if time_ns == self._stated and now - self._stated_at < PERIOD:
            return
        self._stated, self._stated_at = time_ns, now
        self._publisher.publish(Clock(clock=stamp_to_msg(time_ns)))
