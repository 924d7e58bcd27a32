"""The arm's driver in the cell: joint trajectories as ros2_control takes them, poses as Kinova's driver does."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from mbd_model.errors import MbdError
from mbd_robot.geometry import RobotToolPose
from mbd_robot.profiles.robot import ArmInterface, RobotProfile
from mbd_robot.ros.interfaces import interface
from mbd_robot.ros.tool_frames import driver_pose, pose_from_msg, pose_to_msg, suite_pose
from rclpy.node import Node

from mbd_cell.cell import Cell
from mbd_cell.ros.conversions import downward_goal
from mbd_cell.ros.stand_in.following import interpolated
from mbd_cell.ros.stand_in.goals import GoalOutcome, GoalVerdict, StandInAction, Watch

PATH_TOLERANCE, GOAL_TOLERANCE = 0.2, 0.02  # [rad], as UR's driver has them, and ADA's
KINOVA_SPEED = 0.2  # [m/s]
KINOVA_ARRIVED = 0.01  # [m] position_tolerance of kinova_tool_pose_action.cpp
INVALID_JOINTS, PATH_VIOLATED, GOAL_VIOLATED = -2, -4, -5


def arm_action(node: Node, profile: RobotProfile, cell: Cell, refuse: Callable[[], str]) -> StandInAction:
    """The action server of the arm that this profile asks for."""
    arm = profile.arm
    if arm.moveit is not None:
        # It plans, which needs more than the other drivers' parts.
        from mbd_cell.ros.stand_in.move_group import StandInMoveGroup

        return StandInMoveGroup(node, profile, arm.moveit, cell, refuse).action
    if arm.interface is ArmInterface.KINOVA_ARM_POSE:
        kind = interface("kinova_msgs", "action", "ArmPose")
        return StandInAction(node, kind, arm.action, lambda goal: _kinova_pose(kind, profile, cell, goal), refuse)
    kind = interface("control_msgs", "action", "FollowJointTrajectory")
    return StandInAction(node, kind, arm.action, lambda goal: _trajectory(kind, profile, cell, goal), refuse)


def _trajectory(kind: Any, profile: RobotProfile, cell: Cell, goal: Any) -> Watch:
    """As joint_trajectory_controller does: all joints by name, cubic between the points, tolerances on the way."""
    names, points = list(goal.trajectory.joint_names), goal.trajectory.points
    if sorted(names) != sorted(profile.arm.joints) or not points:
        text = f"expected {', '.join(profile.arm.joints)}; got {', '.join(names)}, {len(points)} points"
        return _at_once(kind.Result(error_code=INVALID_JOINTS, error_string=text))
    order = [names.index(n) for n in profile.arm.joints]
    times = np.array([p.time_from_start.sec + p.time_from_start.nanosec * 1e-9 for p in points])
    positions = np.array([p.positions for p in points])[:, order]
    velocities = np.array([p.velocities for p in points])[:, order] if points[0].velocities else None
    if (np.diff(times) <= 0).any() or times[0] < 0:
        return _at_once(kind.Result(error_code=-1, error_string="time_from_start does not rise"))
    start = cell.arm.target.copy()
    cell.follow(interpolated(start, times, positions, velocities))
    late = cell.time_ns + int((times[-1] + 1.0) * 1e9)

    def watch(cancel: bool) -> GoalOutcome | None:
        actual, wanted = cell.simulation.arm_joints, cell.arm.target
        if cancel:
            cell.stop()
            return GoalOutcome(GoalVerdict.CANCELED, kind.Result())
        if np.abs(actual - wanted).max() > PATH_TOLERANCE:
            cell.stop()
            return GoalOutcome(
                GoalVerdict.ABORTED, kind.Result(error_code=PATH_VIOLATED, error_string="path tolerance")
            )
        if np.abs(actual - positions[-1]).max() < GOAL_TOLERANCE and not cell.following:
            return GoalOutcome(GoalVerdict.SUCCEEDED, kind.Result())
        if cell.time_ns > late:
            return GoalOutcome(
                GoalVerdict.ABORTED, kind.Result(error_code=GOAL_VIOLATED, error_string="goal tolerance")
            )
        return None

    return watch


def _at_once(result: Any) -> Watch:
    return lambda _: GoalOutcome(GoalVerdict.ABORTED, result)


def _kinova_pose(kind: Any, profile: RobotProfile, cell: Cell, goal: Any) -> Watch:
    """As kinova_tool_pose_action.cpp does: succeeds within 1 cm, aborts where the arm does not get on."""
    wanted = suite_pose(pose_from_msg(goal.pose.pose), profile.tool_pose)

    def result() -> Any:
        made = kind.Result()
        made.pose.header.frame_id = goal.pose.header.frame_id
        made.pose.pose = pose_to_msg(driver_pose(tool_of(cell), profile.tool_pose))
        return made

    try:
        cell.move_tool(downward_goal(pose_to_msg(wanted)), KINOVA_SPEED)
    except MbdError:
        return lambda _: GoalOutcome(GoalVerdict.ABORTED, result())

    def watch(cancel: bool) -> GoalOutcome | None:
        if cancel:
            cell.stop()
            return GoalOutcome(GoalVerdict.CANCELED, result())
        if cell.busy:
            return None
        near = np.linalg.norm(tool_of(cell).position - wanted.position) < KINOVA_ARRIVED
        return GoalOutcome(GoalVerdict.SUCCEEDED if near else GoalVerdict.ABORTED, result())

    return watch


def tool_of(cell: Cell) -> RobotToolPose:
    """Where the suite's tool is."""
    tool = cell.simulation.tool
    return RobotToolPose(np.array(tool.position), np.array(tool.quaternion))
