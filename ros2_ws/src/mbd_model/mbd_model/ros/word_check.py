"""Notices a wizard's word that reached the dialogue and not this node, or this node and not the dialogue."""

from __future__ import annotations

from mbd_msgs.msg import WizardReply
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from mbd_model.ros.qos import EVENTS

PERIOD = 0.5  # [s] between two looks
LOOKS = 6  # in which a difference lasts before it counts: replies and words overtake each other


class WordCheck:
    """Counts the words of one wizard topic as they reach this node, and compares with what replies state.

    Args:
        node: that calls ``count`` with each word it receives.
        topic: a wizard topic, relative.

    Attributes:
        missed: words that reached the dialogue and not this node; below 0, the other way.
    """

    def __init__(self, node: Node, topic: str) -> None:
        self._node, self._topic = node, topic
        self._mine = 0
        self._theirs: int | None = None  # words that reached the dialogue, as it states
        self._ahead = 0  # words that had reached it before this node counted
        self._looks = 0
        self.missed = 0
        node.create_subscription(WizardReply, "interaction/replies", self._on_reply, EVENTS)
        node.create_timer(PERIOD, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def count(self) -> None:
        """A word was received."""
        self._mine += 1

    def _on_reply(self, reply: WizardReply) -> None:
        if reply.topic.strip("/") != self._topic or not reply.heard:  # 0: a dialogue of an older version
            return
        if self._theirs is None or reply.heard < self._theirs:  # the first, or the dialogue was started again
            self._ahead = reply.heard - max(self._mine, 1)
        self._theirs = reply.heard

    def _look(self) -> None:
        missed = 0 if self._theirs is None else self._theirs - self._ahead - self._mine
        self._looks = self._looks + 1 if missed else 0
        if self._looks < LOOKS or self._theirs is None:
            return
        self.missed += missed
        self._ahead += missed
        self._looks = 0
        if missed > 0:
            self._node.get_logger().error(
                f"{missed} of {self._topic} reached the dialogue and not this node: say it again, by a service "
                "(wizard/...) or `say`, which every node receives"
            )
        else:
            self._node.get_logger().error(
                f"{-missed} of {self._topic} reached this node and not the dialogue: say it again"
            )
