from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

from rclpy.callback_groups import CallbackGroup
from rclpy.node import Node
from rclpy.task import Future
from ros_kinds import Action

GoalT = TypeVar("GoalT")
ResultT = TypeVar("ResultT")
FeedbackT = TypeVar("FeedbackT")

class ResultResponse(Protocol[ResultT]):
    status: int
    result: ResultT

class ClientGoalHandle(Generic[ResultT]):
    @property
    def accepted(self) -> bool: ...
    @property
    def status(self) -> int: ...
    def cancel_goal_async(self) -> Future[object]: ...
    def get_result_async(self) -> Future[ResultResponse[ResultT]]: ...

class ActionClient(Generic[GoalT, ResultT, FeedbackT]):
    def __init__(
        self,
        node: Node,
        action_type: type[Action[GoalT, ResultT, FeedbackT]],
        action_name: str,
        *,
        callback_group: CallbackGroup | None = None,
    ) -> None: ...
    def send_goal_async(
        self, goal: GoalT, feedback_callback: Callable[[object], object] | None = None
    ) -> Future[ClientGoalHandle[ResultT]]: ...
    def server_is_ready(self) -> bool: ...
    def wait_for_server(self, timeout_sec: float | None = None) -> bool: ...
    def destroy(self) -> None: ...
