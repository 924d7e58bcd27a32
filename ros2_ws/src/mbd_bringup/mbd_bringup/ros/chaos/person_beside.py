"""The person beside the robot, who looks and lets it go on after it has stopped."""

from __future__ import annotations

from mbd_model.ros.qos import EVENTS, LATCHED
from mbd_model.ros.stop_line import TOPIC, latch_from_msg
from mbd_model.stop import StopLatch
from mbd_msgs.msg import Stop, WizardCommand
from rclpy.node import Node

PATIENCE = 3.0  # [s] from a stop to the word, and from one word to the next while nothing moves


class PersonBeside:
    """Says RESUME where a stop is held: a driver that is lost, or an arm that left its trajectory, waits for that.

    Args:
        node: that listens, and speaks.
    """

    def __init__(self, node: Node) -> None:
        self._latch, self._since = StopLatch(), 0.0
        self._asked = 0  # number of the stop after which RESUME was said first
        self._words = node.create_publisher(WizardCommand, "wizard/command", EVENTS)
        node.create_subscription(Stop, TOPIC, self._on_stop, LATCHED)

    def _on_stop(self, msg: Stop) -> None:
        self._latch = self._latch.merged(latch_from_msg(msg))

    @property
    def stands(self) -> bool:
        """Whether a stop is held, as far as is known here."""
        return self._latch.held

    def let_go_on(self, now: float) -> bool:
        """Say the word if it is time to; whether that was the first time after a stop.

        Args:
            now: by a clock that never stands still [s].
        """
        latch = self._latch
        if not latch.held:
            self._since = 0.0
            return False
        self._since = self._since or now
        if now - self._since < PATIENCE:
            return False
        self._since = now
        self._words.publish(WizardCommand(command=WizardCommand.RESUME))
        first, self._asked = latch.stopped != self._asked, latch.stopped
        return first
