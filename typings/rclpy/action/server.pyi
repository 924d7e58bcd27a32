from collections.abc import Awaitable, Callable
from enum import Enum
from typing import Generic, TypeVar

from rclpy.callback_groups import CallbackGroup
from rclpy.node import Node
from ros_kinds import Action

GoalT = TypeVar("GoalT")
ResultT = TypeVar("ResultT")
FeedbackT = TypeVar("FeedbackT")

class GoalResponse(Enum):
    REJECT = 1
    ACCEPT = 2

class CancelResponse(Enum):
    REJECT = 1
    ACCEPT = 2

class ServerGoalHandle(Generic[GoalT, ResultT, FeedbackT]):
    @property
    def request(self) -> GoalT: ...
    @property
    def is_active(self) -> bool: ...
    @property
    def is_cancel_requested(self) -> bool: ...
    @property
    def status(self) -> int: ...
    def publish_feedback(self, feedback: FeedbackT) -> None: ...
    def succeed(self) -> None: ...
    def abort(self) -> None: ...
    def canceled(self) -> None: ...

class ActionServer(Generic[GoalT, ResultT, FeedbackT]):
    def __init__(
        self,
        node: Node,
        action_type: type[Action[GoalT, ResultT, FeedbackT]],
        action_name: str,
        execute_callback: Callable[[ServerGoalHandle[GoalT, ResultT, FeedbackT]], ResultT | Awaitable[ResultT]],
        *,
        callback_group: CallbackGroup | None = None,
        goal_callback: Callable[[GoalT], GoalResponse] = ...,
        handle_accepted_callback: Callable[[ServerGoalHandle[GoalT, ResultT, FeedbackT]], None] = ...,
        cancel_callback: Callable[[ServerGoalHandle[GoalT, ResultT, FeedbackT]], CancelResponse] = ...,
    ) -> None: ...
    def destroy(self) -> None: ...
