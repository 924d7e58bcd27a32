"""Waiting after a motion's end until its driver has stated where it ended."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.task import Future

from mbd_robot.motion.standstill import Standstill, Stated

LOOK = 0.02  # [s] between two looks at what is stated
# [s] without a statement after which the last one counts: a simulated clock that stands, or a driver that is lost,
# which the robot node says by itself.
PATIENCE = 5.0


async def at_rest(node: Node, stated: Callable[[], Stated | None], tolerance: float, least: float = 0.0) -> None:
    """Return once what is stated stands still, or nothing is stated any more.

    By the wall clock: simulated time may stand.

    Args:
        node: whose executor waits.
        stated: the newest statement, None where there is none at all: then ``least`` alone is waited.
        tolerance: two statements differ by at most so much where nothing moves, in their unit.
        least: [s] that is waited in any case.
    """
    still = Standstill(stated(), tolerance)
    done: Future[None] = Future(executor=node.executor)
    waited, silent, stands = 0.0, 0.0, False

    def look() -> None:
        nonlocal waited, silent, stands
        now, before = stated(), still.count
        waited += LOOK
        stands = still.stands(now) or stands or now is None
        silent = 0.0 if still.count > before else silent + LOOK
        if waited >= least and (stands or silent >= PATIENCE) and not done.done():
            done.set_result(None)

    timer = node.create_timer(LOOK, look, clock=Clock(clock_type=ClockType.STEADY_TIME))
    try:
        await done
    finally:
        node.destroy_timer(timer)
