"""Spin an executor without ever waiting without end.

``Executor.spin`` waits in the middleware without a time limit, and a context that is shut down just before it begins
to wait may fail to wake it. A timer would, but a node's timers stand when simulated time stands. So the wait here ends
by the steady clock, several times a second, whatever happens.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from typing import Final

from rclpy.executors import Executor, ExternalShutdownException

# Longest wait [s, steady clock]. A node that is idle spends 0.2 % of a core more than one that waits without end.
LONGEST_WAIT: Final = 0.25
# The two lengths [s] that a wait for a certain time is made of.
_NAP, _BREATH = 0.01, 0.002


def spin_until_shutdown(executor: Executor, over: Callable[[], bool] = lambda: False) -> None:
    """Execute callbacks until the executor's context is shut down.

    Args:
        executor: with its nodes.
        over: ends the spin as well; asked at least every ``LONGEST_WAIT``.
    """
    with contextlib.suppress(ExternalShutdownException):
        while executor.context.ok() and not over():
            executor.spin_once(timeout_sec=LONGEST_WAIT)


def spin_for(executor: Executor, seconds: float) -> None:
    """Execute callbacks for that long [s], to within ``_BREATH``; with 0, one of those that are ready.

    rclpy's executor begins its round again with each timeout that differs from the last, and first of all goes on with
    what is under way, such as an action that waits for its end: asked for what is left of a wait, a little less each
    time, it takes nothing else as long as the action lasts. So here the timeouts are always the same.
    """
    end = time.monotonic() + seconds
    for _ in range(2):  # once for what is under way, once for what is new
        executor.spin_once(timeout_sec=0.0)
    while executor.context.ok() and (left := end - time.monotonic()) > 0:
        executor.spin_once(timeout_sec=_NAP if left > _NAP else _BREATH)
