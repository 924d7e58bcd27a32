"""Messages that cannot be used: ignored, logged once each kind, and counted on diagnostics. None ends its node."""

from __future__ import annotations

from collections import Counter

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from mbd_model.ros.qos import EVENTS

PERIOD = 1.0  # [s] between two reports, once there is something to report


class BadMessages:
    """Counts for a node what held what cannot be, such as an enumeration's value that nobody knows.

    A latched message of that kind comes again at each restart of a node: one that died of it would die for ever.

    Attributes:
        count: how many were ignored, by topic.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self.count: Counter[str] = Counter()
        self._last: dict[str, str] = {}
        self._reason = ""
        self._reported = 0
        self._publisher = node.create_publisher(DiagnosticArray, "diagnostics", EVENTS)
        node.create_timer(PERIOD, self._report, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def add(self, topic: str, reason: str) -> None:
        """Count a message of ``topic`` that was ignored, and say so if the reason is another than last time."""
        self.count[topic] += 1
        self._reason = f"{topic}: {reason}"
        if self._last.get(topic) != reason:
            self._last[topic] = reason
            self._node.get_logger().error(f"{topic} is unusable and ignored, the one before stays: {reason}")

    def _report(self) -> None:
        if not self.count:
            return
        self._reported = self.count.total()
        report = DiagnosticArray(
            status=[
                DiagnosticStatus(
                    level=DiagnosticStatus.WARN,
                    name=f"{self._node.get_name()}: messages ignored",
                    message=f"{self._reported} messages were ignored, the last of {self._reason}",
                    values=[KeyValue(key=topic, value=str(count)) for topic, count in self.count.items()],
                )
            ]
        )
        report.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(report)
