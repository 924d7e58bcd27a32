"""The arm as two actions: sends one motion at a time and reports how it ended."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from action_msgs.msg import GoalStatus
from mbd_msgs.action import MoveGripper, MoveTool
from rclpy.action import ActionClient
from rclpy.action.client import ClientGoalHandle
from rclpy.node import Node
from rclpy.task import Future

if TYPE_CHECKING:
    from rclpy.action.client import ResultResponse

from mbd_model.stop import MotionError

from mbd_execution.goals import Ended, Grip, MoveTo, ToolGoal, goal_of

PATIENCE = 10.0  # [s] until an answer that has not come is taken for lost, and an arm that refuses goals for stopped
GONE = 1.0  # [s] until a server that is not there any more is taken for gone

MotionResult = MoveTool.Result | MoveGripper.Result


class ArmClient:
    """Action clients of the arm.

    An answer can be lost: a server may be found before it has found who asks. So none is waited for without end:
    a goal without an answer is sent once again, and cancelled should it be taken late; a result is asked for again. A
    server that was there and is gone, and an arm that goes on refusing goals, end in a failure that stops everything:
    an arm in an emergency stop refuses goals, and must not begin to move when somebody lifts it.

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
        self._now, self._unanswered = 0.0, 0  # [s]; goals in a row without an answer
        self._refused_since: float | None = None  # [s]
        self._missing_since: float | None = None  # [s]
        self._served = False  # both actions were there once
        self.moving = False

    def ready(self) -> str:
        """Name of an action nobody serves, "" when both are there."""
        missing = ""
        if not self._tool.server_is_ready():
            missing = self._names["tool"]
        elif not self._gripper.server_is_ready():
            missing = self._names["gripper"]
        self._served = self._served or not missing
        return missing

    def lost(self, now: float) -> str:
        """Name of an action that was served and is no more, "" while none is; call it now and then.

        Args:
            now: [s] of a clock that never stands still.
        """
        missing = self.ready()
        if not missing or not self._served:
            self._missing_since = None
            return ""
        if self._missing_since is None:
            self._missing_since = now
        return missing if now - self._missing_since >= GONE else ""

    def start(self, motion: MoveTo | Grip, now: float) -> None:
        """Send a motion; ``now`` [s] of a clock that never stands still."""
        self.moving, self._stopping, self._handle = True, False, None
        self._number, self._asked_at, self._now = self._number + 1, now, now
        number = self._number
        self._client, goal = self._goal(motion)
        self._client.send_goal_async(goal).add_done_callback(lambda future: self._accepted(number, future.result()))

    def look_after(self, now: float) -> None:
        """Do something about an answer that does not come; call it now and then while the arm is moving."""
        self._now = now
        if not self.moving or now - self._asked_at < PATIENCE:
            return
        self._asked_at = now
        # A motion may take as long as it likes, its server may not be gone.
        if self._handle is not None and self._client.server_is_ready():
            self._ask_for_result()
            return
        name = self._names["gripper" if self._client is self._gripper else "tool"]
        taken, self._unanswered = self._handle is not None, self._unanswered + 1
        self.forget()
        if taken or self._unanswered > 1:
            why = "is gone amid a motion" if taken else "does not answer goals"
            self._ended(Ended(False, message=f"'{name}' {why}", error=MotionError.DRIVER_LOST), None)
        else:
            self._ended(None, None)

    def forget(self) -> None:
        """Wait for the motion under way no longer: its server is gone. Should it be taken yet, it is cancelled."""
        self._number += 1
        self.moving, self._handle = False, None

    def stop(self) -> None:
        """Have the motion under way stopped; ``ended`` is called when it has."""
        if self.moving and not self._stopping:
            self._stopping = True
            if self._handle is not None:
                self._handle.cancel_goal_async()

    def _goal(self, motion: MoveTo | Grip) -> tuple[ActionClient[Any, Any, Any], MoveTool.Goal | MoveGripper.Goal]:
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
            if handle is not None and handle.accepted:
                handle.cancel_goal_async()  # too late: nobody looks after that motion
            return
        if handle is None or not handle.accepted:
            self._refused()
            return
        self._handle, self._unanswered, self._refused_since = handle, 0, None
        if self._stopping:
            handle.cancel_goal_async()
        self._ask_for_result()

    def _refused(self) -> None:
        """The arm is busy with something else: not tried, so no attempt that failed; unless it goes on so."""
        self.moving = False
        if self._refused_since is None:
            self._refused_since = self._now
        if self._now - self._refused_since < PATIENCE:
            self._ended(None, None)
            return
        self._refused_since = None
        why = f"the arm refuses goals for {PATIENCE:.0f} s: is it in an emergency or protective stop?"
        self._ended(Ended(False, message=why, error=MotionError.PROTECTIVE_STOP), None)

    def _ask_for_result(self) -> None:
        number = self._number

        def answered(future: Future[ResultResponse[Any]]) -> None:
            response = future.result()
            if response is not None:
                self._result(number, response.result, int(response.status))

        if self._handle is not None:
            self._handle.get_result_async().add_done_callback(answered)

    def _result(self, number: int, result: MotionResult, status: int) -> None:
        if number != self._number or not self.moving:
            return  # received before
        stopped, self.moving, self._handle = self._stopping, False, None
        reached = None
        if isinstance(result, MoveTool.Result):
            p, q = result.reached.position, result.reached.orientation
            reached = goal_of((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))
        if stopped and status == GoalStatus.STATUS_CANCELED:
            self._ended(None, reached)
            return
        holding = isinstance(result, MoveGripper.Result) and bool(result.holding)
        success = bool(result.success) and status == GoalStatus.STATUS_SUCCEEDED
        error = MotionError.NONE if success else error_of(result, status)
        message = str(result.message)
        if not success and (result.success or not message):
            message = f"the motion ended as {STATUS_WORDS.get(status, f'status {status}')}, its message: '{message}'"
        self._ended(Ended(success, holding, message, reached, error), reached)


STATUS_WORDS = {
    GoalStatus.STATUS_SUCCEEDED: "succeeded",
    GoalStatus.STATUS_ABORTED: "aborted",
    GoalStatus.STATUS_CANCELED: "cancelled, by somebody else",
    GoalStatus.STATUS_UNKNOWN: "unknown to its server, as after a restart",
}


def error_of(result: MotionResult, status: int) -> MotionError:
    """Why a motion failed. A code nobody knows, and one that does not fit the action's status, state nothing."""
    if status == GoalStatus.STATUS_CANCELED:
        return MotionError.CANCELED
    if status not in (GoalStatus.STATUS_SUCCEEDED, GoalStatus.STATUS_ABORTED):
        return MotionError.DRIVER_LOST
    codes = {error.value: error for error in MotionError}
    return MotionError.NONE if result.success else codes.get(int(result.error_code), MotionError.NONE)
