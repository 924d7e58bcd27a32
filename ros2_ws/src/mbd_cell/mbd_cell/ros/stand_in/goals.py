"""Goals of a driver's action in the cell: begun, watched slice by slice of simulated time, ended."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Any

from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node
from rclpy.task import Future


class GoalVerdict(Enum):
    """How a goal ended."""

    SUCCEEDED = "succeeded"
    ABORTED = "aborted"
    CANCELED = "canceled"


@dataclass(frozen=True)
class GoalOutcome:
    """A goal's end.

    Attributes:
        verdict: the status that the driver gives it.
        result: the action's.
    """

    verdict: GoalVerdict
    result: Any


# Called in each slice until it gives an outcome; the argument: a stop was asked for.
Watch = Callable[[bool], GoalOutcome | None]


class StandInAction:
    """One action server of the stand-in.

    Args:
        node: the server's.
        kind: type of the action.
        name: of the action.
        begin: starts a goal's request and gives what watches it.
        refuse: why a goal is refused now; "" when it is not.
    """

    def __init__(
        self, node: Node, kind: Any, name: str, begin: Callable[[Any], Watch], refuse: Callable[[], str]
    ) -> None:
        self._node, self._name, self._begin, self._refuse = node, name, begin, refuse
        self._handle: ServerGoalHandle[Any, Any, Any] | None = None
        self._watch: Watch | None = None
        self._done: Future[GoalOutcome] | None = None
        ActionServer(
            node,
            kind,
            name,
            self._run,
            goal_callback=self._consider,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    @property
    def running(self) -> bool:
        """Whether a goal is under way."""
        return self._done is not None

    def update(self, *, abort: bool = False) -> bool:
        """Look at the goal, or have the driver give it up; whether it has ended."""
        if self._watch is None or self._handle is None or self._done is None:
            return False
        outcome = self._watch(abort or bool(self._handle.is_cancel_requested))
        if outcome is None:
            return False
        if abort:
            outcome = GoalOutcome(GoalVerdict.ABORTED, outcome.result)
        self._watch = None
        self._done.set_result(outcome)
        return True

    def _consider(self, _: Any) -> GoalResponse:
        why = "a goal is under way" if self.running else self._refuse()
        if why:
            self._node.get_logger().warning(f"{self._name} refused: {why}")
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT

    async def _run(self, handle: ServerGoalHandle[Any, Any, Any]) -> Any:
        self._handle = handle
        self._done = Future(executor=self._node.executor)
        self._watch = self._begin(handle.request)
        outcome = await self._done
        self._handle, self._done = None, None
        if outcome is None:
            raise RuntimeError(f"{self._name}: a goal ended without an outcome")
        if outcome.verdict is GoalVerdict.CANCELED and handle.is_cancel_requested:
            handle.canceled()
        elif outcome.verdict is GoalVerdict.SUCCEEDED:
            handle.succeed()
        else:
            handle.abort()
        return outcome.result
