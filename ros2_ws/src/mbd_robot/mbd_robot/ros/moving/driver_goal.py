"""One goal at a driver's action: sent, watched, cancelled; its end as a value, also when the driver is gone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from rclpy.action.client import ClientGoalHandle
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.task import Future

PERIOD = 0.25  # [s] between two looks whether the driver is still there
ANSWER = 5.0  # [s] until a goal that is not answered is given up


@dataclass(frozen=True)
class GoalEnd:
    """How a goal ended.

    Attributes:
        accepted: the driver took it.
        status: of action_msgs/GoalStatus; unknown where it was never taken, or the driver is gone.
        result: the action's, None where there is none.
        lost: the driver's action server is gone.
    """

    accepted: bool
    status: int = GoalStatus.STATUS_UNKNOWN
    result: Any = None
    lost: bool = False

    @property
    def succeeded(self) -> bool:
        """The driver says that it did what it was asked."""
        return self.status == GoalStatus.STATUS_SUCCEEDED

    @property
    def canceled(self) -> bool:
        """It was stopped because that was asked."""
        return self.status == GoalStatus.STATUS_CANCELED

    @property
    def aborted(self) -> bool:
        """The driver gave it up."""
        return self.status == GoalStatus.STATUS_ABORTED


class DriverAction:
    """An action of a driver, one goal at a time.

    Args:
        node: the client's.
        kind: type of the action.
        name: of the action.
    """

    def __init__(self, node: Node, kind: Any, name: str) -> None:
        self._node, self.kind, self.name = node, kind, name
        self._client: ActionClient[Any, Any, Any] = ActionClient(node, kind, name)
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._handle: ClientGoalHandle[Any] | None = None
        self._cancel = False

    def ready(self) -> bool:
        """Whether the driver serves it."""
        return self._client.server_is_ready()

    async def run(self, goal: Any) -> GoalEnd:
        """Send a goal and wait until it has ended."""
        if not self.ready():
            return GoalEnd(False, lost=True)
        self._cancel, self._handle = False, None
        handle = await self._within(self._client.send_goal_async(goal), ANSWER)
        if handle is None:
            return GoalEnd(False, lost=not self.ready())
        if not handle.accepted:
            return GoalEnd(False)
        self._handle = handle
        if self._cancel:
            handle.cancel_goal_async()
        response = await self._within(handle.get_result_async(), None)
        self._handle = None
        if response is None:
            return GoalEnd(True, lost=True)
        return GoalEnd(True, int(response.status), response.result)

    def cancel(self) -> None:
        """Have the goal under way stopped; ``run`` returns when it is."""
        if not self._cancel:
            self._cancel = True
            if self._handle is not None:
                self._handle.cancel_goal_async()

    async def _within(self, future: Future[Any], patience: float | None) -> Any:
        """The future's result; None where the server is gone, or the patience [s, steady clock] has ended."""
        done: Future[Any] = Future(executor=self._node.executor)
        waited = 0.0

        def end(value: Any) -> None:
            if not done.done():
                done.set_result(value)

        def look() -> None:
            nonlocal waited
            waited += PERIOD
            if not self.ready() or (patience is not None and waited >= patience):
                end(None)

        timer = self._node.create_timer(PERIOD, look, clock=self._steady)
        future.add_done_callback(lambda ended: end(ended.result()))
        try:
            return await done
        finally:
            self._node.destroy_timer(timer)
