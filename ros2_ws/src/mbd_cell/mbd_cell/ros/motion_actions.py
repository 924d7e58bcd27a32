"""The cell's two motion actions: ``cell/move_tool`` and ``cell/move_gripper``."""

from __future__ import annotations

import math
from typing import Any

from mbd_model.errors import MbdError
from mbd_model.ros.stop_line import StopLine
from mbd_msgs.action import MoveGripper, MoveTool
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node
from rclpy.task import Future

from mbd_cell.arm.hand import GripperCommand
from mbd_cell.arm.kinematics import DownwardToolPose
from mbd_cell.cell import Cell
from mbd_cell.ros.conversions import goal_from_msg, pose_to_msg

DEFAULT_SPEED = 0.2  # [m/s]
ARRIVED = 0.01  # [m]


class MotionActions:
    """Serves both actions; the node's loop moves the cell and calls ``update`` after each slice of time."""

    def __init__(self, node: Node, cell: Cell, stop: StopLine) -> None:
        self._node, self._stop = node, stop
        self._cell = cell
        self._goal: DownwardToolPose | None = None
        # Of either action: while the tool moves there is a goal, while the hand moves there is none.
        self._handle: ServerGoalHandle[Any, Any, Any] | None = None
        self._done: Future[None] | None = None
        self._ended = False
        ActionServer(
            node,
            MoveTool,
            "cell/move_tool",
            self._move_tool,
            goal_callback=self._consider,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )
        ActionServer(
            node,
            MoveGripper,
            "cell/move_gripper",
            self._move_gripper,
            goal_callback=self._consider,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    @property
    def running(self) -> bool:
        """True while a goal is being performed."""
        return self._done is not None

    def take_ended(self) -> bool:
        """True once after each motion."""
        ended, self._ended = self._ended, False
        return ended

    def update(self) -> None:
        """Report how far the motion is, and wake the goal when it has ended."""
        if self._done is None or self._handle is None:
            return
        if self._handle.is_cancel_requested or self._stop.latch.held:
            self._cell.stop()
        elif self._cell.busy:
            if self._goal is not None:
                self._handle.publish_feedback(MoveTool.Feedback(distance_left=self._distance()))
            else:
                self._handle.publish_feedback(MoveGripper.Feedback(opening=self._cell.opening))
            return
        self._done.set_result(None)

    def _consider(self, _: object) -> GoalResponse:
        if self._stop.latch.held:
            self._node.get_logger().warning(f"motion goal refused: {self._stop.why}")
            return GoalResponse.REJECT
        if self.running or self._cell.busy:
            self._node.get_logger().warning("motion goal refused: the arm is moving; wait until it has stopped")
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT

    async def _move_tool(
        self, handle: ServerGoalHandle[MoveTool.Goal, MoveTool.Result, MoveTool.Feedback]
    ) -> MoveTool.Result:
        try:
            self._goal = goal_from_msg(handle.request.target)
            self._cell.move_tool(self._goal, handle.request.speed or DEFAULT_SPEED)
        except MbdError as error:
            self._goal = None
            handle.abort()
            return MoveTool.Result(
                success=False,
                message=str(error),
                error_code=MoveTool.Result.NOT_REACHED,
                reached=pose_to_msg(self._cell.simulation.tool),
            )
        await self._motion(handle)
        arrived = self._distance() < ARRIVED
        message = "reached" if arrived else f"stopped {self._distance():.3f} m before the goal"
        self._goal = None
        code = MoveTool.Result.NONE if arrived else self._why_not(handle)
        self._finish(handle, arrived)
        return MoveTool.Result(
            success=arrived, message=message, error_code=code, reached=pose_to_msg(self._cell.simulation.tool)
        )

    def _why_not(self, handle: ServerGoalHandle[Any, Any, Any]) -> int:
        if handle.is_cancel_requested:
            return int(MoveTool.Result.CANCELED)
        return int(MoveTool.Result.EMERGENCY_STOP if self._stop.latch.held else MoveTool.Result.NOT_REACHED)

    async def _move_gripper(
        self, handle: ServerGoalHandle[MoveGripper.Goal, MoveGripper.Result, MoveGripper.Feedback]
    ) -> MoveGripper.Result:
        try:
            command = GripperCommand(handle.request.command)
        except ValueError:
            handle.abort()
            return MoveGripper.Result(
                success=False,
                message=f"command {handle.request.command} is neither OPEN (1) nor CLOSE (2)",
                error_code=MoveGripper.Result.NOT_REACHED,
            )
        self._cell.move_gripper(command)
        await self._motion(handle)
        if self._stop.latch.held:
            code = MoveGripper.Result.CANCELED if handle.is_cancel_requested else MoveGripper.Result.EMERGENCY_STOP
            self._finish(handle, False)
            return MoveGripper.Result(success=False, message=self._stop.why, error_code=code)
        stopped = self._cell.fingers_stopped
        self._finish(handle, True)
        message = f"stopped {self._cell.opening:.0%} open" if stopped else "holding nothing"
        return MoveGripper.Result(success=True, message=message, holding=stopped)

    async def _motion(self, handle: ServerGoalHandle[Any, Any, Any]) -> None:
        self._handle = handle
        self._done = Future(executor=self._node.executor)
        await self._done
        self._handle, self._done = None, None
        self._ended = True

    def _finish(self, handle: ServerGoalHandle[Any, Any, Any], success: bool) -> None:
        if handle.is_cancel_requested:
            handle.canceled()
        elif success:
            handle.succeed()
        else:
            handle.abort()

    def _distance(self) -> float:
        if self._goal is None:
            return 0.0
        return math.dist(self._cell.simulation.tool.position, (self._goal.x, self._goal.y, self._goal.z))
