"""The stop as a node follows it: the topic ``stop``, a service of its own to stop, diagnostics while it holds."""

from __future__ import annotations

import time
from collections.abc import Callable

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from mbd_msgs.msg import Stop
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_msgs.msg import Header
from std_srvs.srv import Trigger

from mbd_model.ros.latch import LatchedPublisher
from mbd_model.ros.qos import EVENTS, LATCHED
from mbd_model.stop import StopCause, StopLatch

TOPIC = "stop"
PERIOD = 1.0  # [s] between two reports on diagnostics while it holds

Changed = Callable[[StopLatch], None]


class StopLine:
    """Follows the stop for a node, and lets it say one.

    Serves ``<node>/stop`` (std_srvs/Trigger). What it knows is published latched and kept in ``state_dir``: a node that
    is started again still stands, and so does one that starts after who said the stop has gone.

    Args:
        node: whose line it is.
        changed: called with the latch when it has changed, after it was kept and published.
        state_dir: folder that keeps it over a restart; "" keeps nothing.
        serve: with the service.

    Attributes:
        latch: what is known.
    """

    def __init__(
        self, node: Node, changed: Changed = lambda _: None, state_dir: str = "", *, serve: bool = True
    ) -> None:
        self._node, self._changed = node, changed
        self._published = LatchedPublisher(node, Stop, TOPIC, state_dir)
        self._reported = False
        self.latch = self._kept()
        node.create_subscription(Stop, TOPIC, self._on_stop, LATCHED)
        if serve:
            node.create_service(Trigger, f"{node.get_name()}/stop", self._on_service)
        self._diagnostics = node.create_publisher(DiagnosticArray, "diagnostics", EVENTS)
        node.create_timer(PERIOD, self._report, clock=Clock(clock_type=ClockType.STEADY_TIME))

    @property
    def why(self) -> str:
        """Why nothing may move, "" when it may."""
        return f"stopped: {self.latch.reason or self.latch.cause.name.lower()}" if self.latch.held else ""

    def _kept(self) -> StopLatch:
        last = self._published.last
        try:
            return StopLatch() if last is None else latch_from_msg(last)
        except ValueError as error:
            self._node.get_logger().error(f"the kept stop cannot be ({error}): standing still")
            return StopLatch().stop(time.time_ns(), StopCause.UNKNOWN, "the kept stop cannot be read")

    def stop(self, cause: StopCause, reason: str) -> None:
        """Have everything stand; while it does, another reason is logged and changes nothing."""
        if self.latch.held:
            return
        self._take(self.latch.stop(time.time_ns(), cause, reason))

    def release(self) -> None:
        """A person lets the robot go on."""
        self._take(self.latch.release())

    def _take(self, latch: StopLatch) -> None:
        if latch == self.latch:
            return
        before, self.latch = self.latch, latch
        self._published.publish(latch_to_msg(latch, self._node))
        # rclpy ties a place in the code to one severity.
        if latch.held and latch.stopped != before.stopped:
            self._node.get_logger().error(f"{self.why}; everything stands until a person resumes")
        elif before.held and not latch.held:
            self._node.get_logger().info("a person let the robot go on")
        self._report()
        self._changed(latch)

    def _on_stop(self, msg: Stop) -> None:
        try:
            received = latch_from_msg(msg)
        except ValueError as error:  # MbdError is one
            # What nobody understands was meant to stop: a needless stop can be released, a missed one not taken back.
            self.stop(StopCause.UNKNOWN, f"a stop came that cannot be read ({error}): {msg.reason}")
            return
        if not received.stopped and not received.released:
            self.stop(received.cause, received.reason or "somebody published a stop")
            return
        self._take(self.latch.merged(received))

    def _on_service(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self.stop(StopCause.PERSON, f"the service {self._node.get_name()}/stop was called")
        response.success, response.message = True, self.why
        return response

    def _report(self) -> None:
        """An error each second while it holds, and once that it does no more."""
        held = self.latch.held
        if not held and not self._reported:
            return
        self._reported = held
        status = DiagnosticStatus(
            level=DiagnosticStatus.ERROR if held else DiagnosticStatus.OK,
            name=f"{self._node.get_name()}: stop",
            message=self.why or "a person let the robot go on",
            values=[KeyValue(key="cause", value=self.latch.cause.name)],
        )
        header = Header(stamp=self._node.get_clock().now().to_msg())
        self._diagnostics.publish(DiagnosticArray(header=header, status=[status]))


def latch_from_msg(msg: Stop) -> StopLatch:
    """What a message states; raises ValueError for a cause there is not, MbdError for numbers that cannot be."""
    return StopLatch(int(msg.stopped), int(msg.released), StopCause(msg.cause), msg.reason)


def latch_to_msg(latch: StopLatch, node: Node) -> Stop:
    """The latch as a message, stamped with the node's clock."""
    return Stop(
        header=Header(stamp=node.get_clock().now().to_msg()),
        stopped=latch.stopped,
        released=latch.released,
        cause=latch.cause,
        reason=latch.reason,
    )
