"""The arm as two actions: sends one motion at a time and reports how it ended."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from mbd_msgs.action import MoveGripper, MoveTool
from rclpy.action import ActionClient
from rclpy.action.client import ClientGoalHandle
from rclpy.node import Node
from rclpy.task import Future

if TYPE_CHECKING:
    from rclpy.action.client import ResultResponse

from mbd_execution.goals import Ended, Grip, Motion, ToolGoal, goal_of

PATIENCE = 10.0  # [s] until an answer that has not come is taken for lost

MotionResult = MoveTool.Result | MoveGripper.Result


class ArmClient:
    """Action clients of the arm.

    An answer can be lost: a server may be found before it has found who asks. So none is waited for without end:
    a goal without an answer counts as not taken (motions may be sent twice), a result is asked for again, and a motion
    whose server is gone counts as stopped.

    Args:
        node: whose clients they are.
        move_tool: name of the action that moves the tool.
        move_gripper: name of the action that moves the fingers.
        frame: of the goals.
        ended: called with how a motion ended; None: it was stopped, and the tool is at the second argument.
    """

    def __init__(
        self,
        node: Node,
        move_tool: str,
        move_gripper: str,
        frame: str,
        ended: Callable[[Ended | None, ToolGoal | None], None],
    ) -> None:
        self._node = node
        self._names = {"tool": move_tool, "gripper": move_gripper}
        self._tool = ActionClient(node, MoveTool, move_tool)
        self._gripper = ActionClient(node, MoveGripper, move_gripper)
        self._frame, self._ended = frame, ended
        self._client: ActionClient[Any, Any, Any] = self._tool  # of the motion under way
        # Of either action: its result states of which.
        self._handle: ClientGoalHandle[Any] | None = None
        self._stopping = False
        self._number, self._asked_at = 0, 0.0  # of the motion; when its last answer was asked for [s]
        self.moving = False

    def ready(self) -> str:
        """Name of an action nobody serves, "" when both are there."""
        if not self._tool.server_is_ready():
            return self._names["tool"]
        return "" if self._gripper.server_is_ready() else self._names["gripper"]

    def start(self, motion: Motion, now: float) -> None:
        """Send a motion; ``now`` [s] of a clock that never stands still."""
        self.moving, self._stopping, self._handle = True, False, None
        self._number, self._asked_at = self._number + 1, now
        number = self._number
        self._client, goal = self._goal(motion)
        self._client.send_goal_async(goal).add_done_callback(lambda future: self._accepted(number, future.result()))

    def look_after(self, now: float) -> None:
        """Do something about an answer that does not come; call it now and then while the arm is moving."""
        if not self.moving or now - self._asked_at < PATIENCE:
            return
        self._asked_at = now
        # A motion may take as long as it likes, its server may not be gone.
        if self._handle is not None and self._client.server_is_ready():
            self._ask_for_result()
            return
        self._number += 1
        self.moving = False
        self._ended(None, None)

    def stop(self) -> None:
        """Have the motion under way stopped; ``ended`` is called when it has."""
        if self.moving and not self._stopping:
            self._stopping = True
            if self._handle is not None:
                self._handle.cancel_goal_async()

    def _goal(self, motion: Motion) -> tuple[ActionClient[Any, Any, Any], MoveTool.Goal | MoveGripper.Goal]:
        if isinstance(motion, Grip):
            command = MoveGripper.Goal.CLOSE if motion.close else MoveGripper.Goal.OPEN
            return self._gripper, MoveGripper.Goal(command=command)
        goal = MoveTool.Goal(speed=motion.speed)
        goal.target.header.frame_id = self._frame
        goal.target.header.stamp = self._node.get_clock().now().to_msg()
        goal.target.pose.position.x = motion.goal.x
        goal.target.pose.position.y = motion.goal.y
        goal.target.pose.position.z = motion.goal.z
        q = goal.target.pose.orientation
        q.x, q.y, q.z, q.w = motion.goal.quaternion
        return self._tool, goal

    def _accepted(self, number: int, handle: ClientGoalHandle[Any] | None) -> None:
        if number != self._number:
            return  # too late
        if handle is None or not handle.accepted:
            # The arm is busy with something else: not tried, so no attempt that failed.
            self.moving = False
            self._ended(None, None)
            return
        self._handle = handle
        if self._stopping:
            handle.cancel_goal_async()
        self._ask_for_result()

    def _ask_for_result(self) -> None:
        number = self._number

        def answered(future: Future[ResultResponse[Any]]) -> None:
            response = future.result()
            if response is not None:
                self._result(number, response.result)

        if self._handle is not None:
            self._handle.get_result_async().add_done_callback(answered)

    def _result(self, number: int, result: MotionResult) -> None:
        if number != self._number or not self.moving:
            return  # received before
        stopped, self.moving, self._handle = self._stopping, False, None
        reached = None
        if isinstance(result, MoveTool.Result):
            p, q = result.reached.position, result.reached.orientation
            reached = goal_of((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))
        if stopped and not result.success:
            self._ended(None, reached)
            return
        holding = isinstance(result, MoveGripper.Result) and bool(result.holding)
        self._ended(Ended(bool(result.success), holding, result.message, reached), reached)
