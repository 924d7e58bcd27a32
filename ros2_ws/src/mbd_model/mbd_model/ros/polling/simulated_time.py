"""Simulated time, looked up when somebody asks what time it is.

A simulated clock states the time some hundred times a second to each node of a session, and most nodes have nothing to
do then: waking their executors for it was the larger part of what a session in the cell took of the processor.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from rclpy.clock import Clock as RosClock
from rclpy.clock import ClockType
from rclpy.exceptions import InvalidHandle
from rclpy.node import Node
from rclpy.subscription import Subscription
from rosgraph_msgs.msg import Clock

from mbd_model.ros.polling.subscriptions import taken

PERIOD = 0.25  # [s, wall clock] between two looks while nobody asks: what a timer of simulated time may be late by


class SimulatedTime:
    """What /clock states last.

    Args:
        node: whose clock it sets.
        subscription: of its /clock, in an ``UnwaitedGroup``.
        set_time: sets the node's clock by a message.
    """

    def __init__(self, node: Node, subscription: Subscription[Any], set_time: Callable[[Clock], None]) -> None:
        self._subscription, self._set_time = subscription, set_time
        # A page's thread asks for the time as well as the executor's.
        self._taking = threading.Lock()
        self._timer = node.create_timer(PERIOD, self.take, clock=RosClock(clock_type=ClockType.STEADY_TIME))

    def take(self) -> None:
        """Set the node's clock to what was stated last; nothing while another thread is at it."""
        if not self._taking.acquire(blocking=False):
            return
        try:
            for stated in taken(self._subscription, Clock):
                self._set_time(stated)
        except InvalidHandle:
            # use_sim_time was switched off, which ends the subscription.
            with suppress(InvalidHandle):
                self._timer.cancel()
        finally:
            self._taking.release()
