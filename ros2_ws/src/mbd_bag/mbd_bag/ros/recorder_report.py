"""What a recorder misses, on diagnostics and in its bag's facts."""

from __future__ import annotations

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from mbd_model.ros.qos import EVENTS
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from mbd_bag.recorder.session_recording import SessionRecording
from mbd_bag.recorder.topic_counts import count_facts

_PERIOD = 2.0  # [s] between two reports
_FACTS_EVERY = 5  # reports between two additions to the bag: a recorder that is killed adds none at its end
# Names of the report and of what is in it; the console reads them.
STATUS, MISSED, RECORDING, DISK_LEFT = "recorder: topics", "missed", "recording", "disk left [MB]"


class RecorderReport:
    """Publishes the counts of every topic, and adds them to the bag when messages are missing.

    Args:
        node: of the recorder.
        recording: what it counts; its counts are only read.
    """

    def __init__(self, node: Node, recording: SessionRecording) -> None:
        self._node, self._recording, self._counts = node, recording, recording.counts
        self._missing = self._warned = self._stated = self._reports = 0
        self._publisher = node.create_publisher(DiagnosticArray, "diagnostics", EVENTS)
        node.create_timer(_PERIOD, self._report, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _report(self) -> None:
        self._reports += 1
        missing = sum(count.missing for count in self._counts.values())
        status = DiagnosticStatus(level=DiagnosticStatus.OK, name=STATUS, message=self._words(missing))
        if missing > self._missing:
            status.level = DiagnosticStatus.WARN
            # The report states each; the log, when there are twice as many as it stated.
            if missing >= 2 * self._warned:
                self._warned = missing
                self._node.get_logger().warning(status.message)
        self._missing = missing
        status.values = [KeyValue(key=MISSED, value=str(missing))]
        status.values.append(
            KeyValue(key=RECORDING, value="yes" if self._recording.open else "no, the session is over")
        )
        left = self._recording.output.writer.free_space() / 1e6
        status.values.append(KeyValue(key=DISK_LEFT, value=f"{left:.0f}"))
        status.values += [KeyValue(key=t, value=c.text()) for t, c in sorted(self._counts.items()) if c.received]
        status.values.append(
            KeyValue(key="waiting to be written [MB]", value=f"{self._recording.budget.used / 1e6:.1f}")
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(array)
        if missing > self._stated and self._reports % _FACTS_EVERY == 0:
            self._stated = missing
            self._recording.state_now(count_facts(self._counts))

    def _words(self, missing: int) -> str:
        written = sum(count.written for count in self._counts.values())
        if not missing:
            return f"{written} messages written, none missed"
        worst = max(self._counts, key=lambda topic: self._counts[topic].missing)
        return f"{written} messages written, {missing} missed, most of {worst} ({self._counts[worst].text()})"
