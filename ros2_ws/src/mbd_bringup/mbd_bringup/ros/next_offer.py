"""Offers the session that the plan has next to the operator's pages, and takes their word that it is to begin."""

from __future__ import annotations

from mbd_model.ros.qos import EVENTS, LATCHED
from mbd_msgs.msg import NextSession
from mbd_study.plan.schedule import PlannedSession
from rclpy.node import Node


class NextOffer:
    """Latches ``session/next`` and listens on ``session/begin``.

    Args:
        node: whose topics these are.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._offered = ""
        self._begun = False
        self._publisher = node.create_publisher(NextSession, "session/next", LATCHED)
        node.create_subscription(NextSession, "session/begin", self._on_begin, EVENTS)

    @property
    def begun(self) -> bool:
        """Whether somebody asked for the session that is offered to begin."""
        return self._begun

    def offer(self, planned: PlannedSession | None, problem: str = "") -> None:
        """State which session is next.

        Args:
            planned: that session; None when the plan has none left.
            problem: why it cannot begin, a sentence; "" when it can.
        """
        said = NextSession(problem=problem)
        said.header.stamp = self._node.get_clock().now().to_msg()
        if planned is not None:
            said.session, said.participant = planned.session, planned.participant
            said.task, said.condition = planned.task, planned.condition
        self._offered = "" if problem else said.session
        self._publisher.publish(said)

    def _on_begin(self, msg: NextSession) -> None:
        # A click that was meant for an offer of before begins nothing.
        if self._offered and msg.session == self._offered:
            self._begun = True
        else:
            self._node.get_logger().warning(
                f"session '{msg.session}' is not begun: offered is '{self._offered or 'none'}'"
            )
