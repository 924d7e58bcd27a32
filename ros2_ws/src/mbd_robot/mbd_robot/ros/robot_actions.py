"""The suite's two motion actions, passed on to the drivers: robot/move_tool and robot/move_gripper."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from mbd_model.errors import MbdError
from mbd_model.stop import MotionError
from mbd_msgs.action import MoveGripper, MoveTool
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node

from mbd_robot.geometry import RobotToolPose
from mbd_robot.motion.standstill import Stated
from mbd_robot.ros.moving.arm_motion import ArmMotion
from mbd_robot.ros.moving.goal_end import ArmMotionEnd
from mbd_robot.ros.moving.hand_motion import HandMotion, HandMotionEnd
from mbd_robot.ros.moving.rest import at_rest
from mbd_robot.ros.tool_frames import pose_from_msg, pose_to_msg
from mbd_robot.topics import MOVE_GRIPPER, MOVE_TOOL

DEFAULT_SPEED = 0.1  # [m/s]
STILL = 0.001  # [m] by which an arm's statements of its tool differ where it stands


class RobotActions:
    """Serves both actions, one goal at a time.

    Args:
        node: the server's.
        frame: of the goals.
        fastest: [m/s] of the tool; 0: as the goals ask.
        tool: where the suite's tool was last stated to be, None where that is not known.
        tool_stated: its position [m] with the number of the statement.
        refusal: why nothing may move now; "" when it may.
    """

    def __init__(
        self,
        node: Node,
        frame: str,
        fastest: float,
        *,
        tool: Callable[[], RobotToolPose | None],
        tool_stated: Callable[[], Stated | None],
        refusal: Callable[[], str],
    ) -> None:
        self._node, self._frame, self._fastest = node, frame, fastest
        self._tool, self._tool_stated, self._refusal = tool, tool_stated, refusal
        self.arm: ArmMotion | None = None
        self.hand: HandMotion | None = None
        self.busy = False
        words: dict[str, Any] = {"goal_callback": self._consider, "cancel_callback": self._cancel}
        ActionServer(node, MoveTool, MOVE_TOOL, self._move_tool, **words)
        ActionServer(node, MoveGripper, MOVE_GRIPPER, self._move_gripper, **words)

    def stop(self) -> None:
        """Cancel what is under way at the drivers."""
        for part in (self.arm, self.hand):
            if part is not None:
                part.cancel()

    def _consider(self, _: object) -> GoalResponse:
        why = "a motion is under way" if self.busy else self._refusal()
        if why:
            self._node.get_logger().warning(f"motion goal refused: {why}", throttle_duration_sec=2.0)
            return GoalResponse.REJECT
        self.busy = True
        return GoalResponse.ACCEPT

    def _cancel(self, _: object) -> CancelResponse:
        self.stop()
        return CancelResponse.ACCEPT

    async def _move_tool(
        self, handle: ServerGoalHandle[MoveTool.Goal, MoveTool.Result, MoveTool.Feedback]
    ) -> MoveTool.Result:
        try:
            end = await self._moved(handle.request)
            if end.code is not MotionError.DRIVER_LOST:
                await at_rest(self._node, self._tool_stated, STILL)
        except MbdError as error:
            # No way there: nothing is wrong with the robot.
            end = ArmMotionEnd(False, str(error), MotionError.NOT_REACHED)
        finally:
            self.busy = False
        result = MoveTool.Result(success=end.success, message=end.message or "reached")
        now = self._tool()
        if now is not None:
            result.reached = pose_to_msg(now)
        _finish(handle, result, end.code)
        return result

    async def _moved(self, request: MoveTool.Goal) -> ArmMotionEnd:
        target, speed = request.target, float(request.speed) or DEFAULT_SPEED
        if target.header.frame_id not in ("", self._frame):
            raise MbdError(f"goal in frame '{target.header.frame_id}'; this robot takes goals in '{self._frame}'")
        if self.arm is None or (missing := self.arm.ready()):
            text = f"the arm cannot be moved: {missing if self.arm else 'its model'} is missing"
            return ArmMotionEnd(False, text, MotionError.DRIVER_LOST)
        return await self.arm.move(pose_from_msg(target.pose), min(speed, self._fastest) if self._fastest else speed)

    async def _move_gripper(
        self, handle: ServerGoalHandle[MoveGripper.Goal, MoveGripper.Result, MoveGripper.Feedback]
    ) -> MoveGripper.Result:
        try:
            end = await self._gripped(handle.request.command)
        finally:
            self.busy = False
        result = MoveGripper.Result(success=end.success, message=end.message, holding=end.holding)
        _finish(handle, result, end.code)
        return result

    async def _gripped(self, command: int) -> HandMotionEnd:
        if command not in (MoveGripper.Goal.OPEN, MoveGripper.Goal.CLOSE):
            text = f"command {command} is neither OPEN (1) nor CLOSE (2)"
            return HandMotionEnd(False, message=text, code=MotionError.NOT_REACHED)
        if self.hand is None or (missing := self.hand.ready()):
            text = f"the hand cannot be moved: {missing if self.hand else 'its interface'} is missing"
            return HandMotionEnd(False, message=text, code=MotionError.DRIVER_LOST)
        return await self.hand.move(command == MoveGripper.Goal.CLOSE)


def _finish(
    handle: ServerGoalHandle[Any, Any, Any], result: MoveTool.Result | MoveGripper.Result, code: MotionError
) -> None:
    """Give the goal its status, and the result its code."""
    result.error_code = int(code)
    if handle.is_cancel_requested:
        handle.canceled()
    elif result.success:
        handle.succeed()
    else:
        handle.abort()
