"""Spin an executor without ever waiting without end.

``Executor.spin`` waits in the middleware without a time limit, and a context that is shut down just before it begins
to wait may fail to wake it. A timer would, but a node's timers stand when simulated time stands. So the wait here ends
by the steady clock, several times a second, whatever happens.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Final

from rclpy.executors import Executor, ExternalShutdownException

# Longest wait [s, steady clock]. A node that is idle spends 0.2 % of a core more than one that waits without end.
LONGEST_WAIT: Final = 0.25


def spin_until_shutdown(executor: Executor, over: Callable[[], bool] = lambda: False) -> None:
    """Execute callbacks until the executor's context is shut down.

    Args:
        executor: with its nodes.
        over: ends the spin as well; asked at least every ``LONGEST_WAIT``.
    """
    with contextlib.suppress(ExternalShutdownException):
        while executor.context.ok() and not over():
            executor.spin_once(timeout_sec=LONGEST_WAIT)
