"""The arm told to move by MoveIt 2: goals of the tool, with table and perceived boxes as its planning scene."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from geometry_msgs.msg import Point, Pose, Quaternion
from mbd_model.errors import MbdError
from rclpy.node import Node
from scipy.spatial.transform import Rotation

from mbd_robot.geometry import Obstacle, RobotToolPose, Surroundings
from mbd_robot.profiles.moveit import MoveItProfile
from mbd_robot.profiles.robot import RobotProfile
from mbd_robot.ros.interfaces import interface
from mbd_robot.ros.moving.driver_goal import DriverAction, GoalEnd
from mbd_robot.ros.moving.goal_end import ArmMotionEnd, ended
from mbd_robot.ros.moving.moveit_held import HeldInMoveIt
from mbd_robot.ros.tool_frames import driver_pose, pose_to_msg

POSITION, ROTATION = 0.001, 0.01  # [m], [rad] within which the goal counts as reached
REACH = 0.12  # [m] of the tool's goal and of where it is: what stands so near is what the hand reaches for
# x, y, z [m] of the table as a box, and how far below its top it ends: fingers go down to it.
TABLE, SUNK = (1.2, 2.0, 1.0), 0.01
TABLE_MIDDLE = 0.75  # [m] in front of the robot
INVALIDATED = -3  # MoveItErrorCodes.MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE
# What a wrong profile gives, by MoveItErrorCodes.
MISTAKES = {
    -15: "there is no such planning group: see moveit.group of the profile",
    -18: "there is no such link: see arm.tip of the profile",
    -21: "a frame is unknown: see base_frame of the profile",
}
REASONS = {
    -1: "no plan was found",
    -2: "the plan would touch something",
    -6: "no plan was found in time",
    -10: "the arm touches something where it is",
    -12: "the arm would touch something at its goal",
    -13: "the goal is outside what is allowed",
    -26: "the arm is where it may not be",
    -31: "the arm does not reach the goal",
}

Tool = Callable[[], RobotToolPose | None]
Around = Callable[[], Surroundings]


class MoveGroupArm:
    """Sends tool poses to MoveIt's MoveGroup action, its planners one after the other.

    Args:
        node: the client's.
        profile: with a section moveit.
        tool: where the suite's tool is.
        around: boxes to keep clear of, and what is in the hand.
        table_height: [m] of the table's top.
    """

    def __init__(self, node: Node, profile: RobotProfile, tool: Tool, around: Around, table_height: float) -> None:
        if profile.arm.moveit is None:
            raise MbdError(f"{profile.title} has no section moveit")
        self._node, self._profile, self._moveit = node, profile, profile.arm.moveit
        self._tool, self._around, self._table = tool, around, table_height
        self._held = HeldInMoveIt(node, profile)
        self._action = DriverAction(node, interface("moveit_msgs", "action", "MoveGroup"), profile.arm.action)

    def ready(self) -> str:
        """Name of what is missing, "" when the arm can be moved."""
        return "" if self._action.ready() else f"MoveIt's action {self._action.name}"

    async def move(self, goal: RobotToolPose, speed: float) -> ArmMotionEnd:
        """Move the tool there, at most so fast [m/s]; raises MbdError where no planner finds a way."""
        refusals = []
        self._held.tell(self._around().held)
        for planner in self._moveit.planners:
            end = await self._action.run(self._goal(goal, speed, planner))
            why = no_way(end)
            if not why:
                return ended(end, self._action.name, execution_error(end))
            refusals.append(f"{planner}: {why}")
        raise MbdError(f"MoveIt finds no way: {'; '.join(refusals)}")

    def cancel(self) -> None:
        """Stop the motion under way."""
        self._action.cancel()

    def _goal(self, goal: RobotToolPose, speed: float, planner: str) -> Any:
        made = self._action.kind.Goal()
        fill_request(made.request, self._moveit, planner, speed)
        made.request.goal_constraints = [self._constraints(driver_pose(goal, self._profile.tool_pose))]
        scene = made.planning_options.planning_scene_diff
        scene.is_diff = scene.robot_state.is_diff = True
        now = self._tool()
        hand = [goal.position] if now is None else [goal.position, now.position]
        around = [o for o in self._around().obstacles if all(distance(o, p) > REACH for p in hand)]
        scene.world.collision_objects = [self._box(o) for o in (self._table_box(), *around)]
        return made

    def _constraints(self, tip: RobotToolPose) -> Any:
        """The tip's pose as MoveIt's own kinematic_constraints::constructGoalConstraints has it."""
        made = interface("moveit_msgs", "msg", "Constraints")()
        position = interface("moveit_msgs", "msg", "PositionConstraint")()
        orientation = interface("moveit_msgs", "msg", "OrientationConstraint")()
        solid = interface("shape_msgs", "msg", "SolidPrimitive")
        pose, link = pose_to_msg(tip), self._profile.arm.tip
        for constraint in (position, orientation):
            constraint.header.frame_id = self._profile.base_frame
            constraint.link_name, constraint.weight = link, 1.0
        position.constraint_region.primitives = [solid(type=solid.SPHERE, dimensions=[POSITION])]
        position.constraint_region.primitive_poses = [Pose(position=pose.position)]
        orientation.orientation = pose.orientation
        orientation.parameterization = orientation.ROTATION_VECTOR
        orientation.absolute_x_axis_tolerance = ROTATION
        orientation.absolute_y_axis_tolerance = ROTATION
        orientation.absolute_z_axis_tolerance = ROTATION
        made.position_constraints, made.orientation_constraints = [position], [orientation]
        return made

    def _table_box(self) -> Obstacle:
        return Obstacle("table", (TABLE_MIDDLE, 0.0, self._table - SUNK - TABLE[2] / 2), TABLE)

    def _box(self, box: Obstacle) -> Any:
        made = interface("moveit_msgs", "msg", "CollisionObject")()
        solid = interface("shape_msgs", "msg", "SolidPrimitive")
        made.header.frame_id, made.id, made.operation = self._profile.base_frame, box.name, made.ADD
        made.primitives = [solid(type=solid.BOX, dimensions=list(box.size))]
        made.primitive_poses = [box_pose(box)]
        made.pose.orientation.w = 1.0
        return made


def fill_request(request: Any, moveit: MoveItProfile, planner: str, speed: float) -> None:
    """Who plans, and how fast; the start is where the arm is."""
    request.pipeline_id, _, request.planner_id = planner.partition("/")
    request.group_name = moveit.group
    request.start_state.is_diff = True
    request.num_planning_attempts = 1
    request.allowed_planning_time = moveit.planning_time
    request.max_velocity_scaling_factor = min(1.0, max(0.001, speed / moveit.full_speed))
    request.max_acceleration_scaling_factor = moveit.acceleration


def box_pose(box: Obstacle) -> Pose:
    """Of its middle, in the base frame."""
    x, y, z = box.centre
    i, j, k, w = (float(v) for v in Rotation.from_euler("z", box.yaw).as_quat())
    return Pose(position=Point(x=x, y=y, z=z), orientation=Quaternion(x=i, y=j, z=k, w=w))


def distance(box: Obstacle, point: Any) -> float:
    """From a point (3,) to the box [m], 0 inside."""
    local = Rotation.from_euler("z", -box.yaw).apply(np.asarray(point) - box.centre)
    return float(np.linalg.norm(np.maximum(np.abs(local) - np.array(box.size) / 2, 0.0)))


def no_way(end: GoalEnd) -> str:
    """Why MoveIt did not even set out; "" where it did, or was stopped, or is not there."""
    if not end.aborted or end.result is None:
        return ""
    code, planned = int(end.result.error_code.val), end.result.planned_trajectory.joint_trajectory.points
    if planned and code != INVALIDATED:
        return ""
    if code == INVALIDATED:
        return "something came into the way"
    if code in MISTAKES:
        return MISTAKES[code]
    said = str(end.result.error_code.message)
    return REASONS.get(code, f"it failed (MoveItErrorCodes {code}); is the pipeline loaded?") + (
        f" ({said})" if said else ""
    )


def execution_error(end: GoalEnd) -> str:
    """Why a motion that was under way ended, for people; "" where it did not fail."""
    if end.result is None or not end.aborted:
        return ""
    code = int(end.result.error_code.val)
    return f"MoveIt's controller gave the motion up (MoveItErrorCodes {code}): something in the way, or a stop"
