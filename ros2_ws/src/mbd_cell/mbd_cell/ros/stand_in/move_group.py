"""MoveIt's MoveGroup in the cell: plans with our own planner, and answers as move_action_capability.cpp does."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from mbd_model.errors import MbdError
from mbd_robot.geometry import HeldBoxes, Obstacle, RobotToolPose
from mbd_robot.kinematics.chain import ArmChain
from mbd_robot.motion.planning import MotionPlanner
from mbd_robot.motion.timing import TimedJoints
from mbd_robot.profiles.moveit import MoveItProfile
from mbd_robot.profiles.robot import RobotProfile
from mbd_robot.ros.interfaces import interface
from mbd_robot.ros.moving.arm_motion import fill_trajectory
from mbd_robot.ros.tool_frames import driver_pose, pose_from_msg, suite_pose
from rclpy.node import Node

from mbd_cell.cell import Cell
from mbd_cell.ros.stand_in.following import interpolated
from mbd_cell.ros.stand_in.goals import GoalOutcome, GoalVerdict, StandInAction, Watch

SUCCESS, FAILURE, PLANNING_FAILED, CONTROL_FAILED, PREEMPTED = 1, 99999, -1, -4, -7
INVALID_GROUP_NAME, INVALID_LINK_NAME = -15, -18
TOLERANCE = 0.02  # [rad] of a joint at the goal


class StandInMoveGroup:
    """Answers goals of one arm.

    Args:
        node: the server's.
        profile: with a section moveit.
        moveit: that section.
        cell: whose arm moves.
        refuse: why the arm's controller takes no trajectory now; "" when it does.
    """

    def __init__(
        self, node: Node, profile: RobotProfile, moveit: MoveItProfile, cell: Cell, refuse: Callable[[], str]
    ) -> None:
        self._profile, self._moveit, self._cell, self._refuse = profile, moveit, cell, refuse
        self._chain = ArmChain(profile, table_height=None)
        self._planner = MotionPlanner(self._chain)
        self._kind = interface("moveit_msgs", "action", "MoveGroup")
        # It takes every goal, and says in its result what became of it.
        scenes = interface("moveit_msgs", "msg", "PlanningScene")
        node.create_subscription(scenes, "planning_scene", self._on_scene, 10)
        self._attached: dict[str, Any] = {}
        self.action = StandInAction(node, self._kind, profile.arm.action, self._begin, lambda: "")

    def _begin(self, goal: Any) -> Watch:
        request = goal.request
        constraints = request.goal_constraints[0]
        if request.group_name != self._moveit.group:
            return self._at_once(INVALID_GROUP_NAME)
        if constraints.position_constraints[0].link_name != self._profile.arm.tip:
            return self._at_once(INVALID_LINK_NAME)
        if request.pipeline_id not in ("pilz_industrial_motion_planner", "ompl"):
            return self._at_once(FAILURE)
        self._chain.surround(boxes(goal.planning_options.planning_scene_diff))
        try:
            timed = self._plan(constraints, request)
        except MbdError:
            return self._at_once(PLANNING_FAILED)
        result = self._kind.Result()
        fill_trajectory(result.planned_trajectory.joint_trajectory, self._profile.arm.joints, timed)
        if self._refuse():
            result.error_code.val = CONTROL_FAILED
            return lambda _: GoalOutcome(GoalVerdict.ABORTED, result)
        self._cell.follow(self._way(timed))
        return self._watch(result, timed)

    def _on_scene(self, msg: Any) -> None:
        """What is attached to the tip, and what no more."""
        for one in msg.robot_state.attached_collision_objects:
            if one.object.operation == one.object.ADD:
                self._attached[one.object.id] = one.object
            else:
                self._attached.pop(one.object.id, None)
        tool = self._chain.tool_pose(np.array(self._cell.simulation.arm_joints))
        tip = driver_pose(tool, self._profile.tool_pose)
        boxes = tuple(box_of(thing, tip) for thing in self._attached.values())
        self._chain.hold(HeldBoxes(boxes, tool if boxes else None))

    def _plan(self, constraints: Any, request: Any) -> TimedJoints:
        position = constraints.position_constraints[0].constraint_region.primitive_poses[0]
        position.orientation = constraints.orientation_constraints[0].orientation
        goal = suite_pose(pose_from_msg(position), self._profile.tool_pose)
        now = np.array(self._cell.simulation.arm_joints)
        speed = request.max_velocity_scaling_factor * self._moveit.full_speed
        if request.planner_id == "LIN":
            return self._planner.direct(now, goal, speed)
        return self._planner.plan(now, goal, speed)

    def _way(self, timed: TimedJoints) -> Iterator[Any]:
        return interpolated(self._cell.arm.target.copy(), timed.times, timed.positions, timed.velocities)

    def _watch(self, result: Any, timed: TimedJoints) -> Watch:
        def watch(cancel: bool) -> GoalOutcome | None:
            if cancel:
                self._cell.stop()
                result.error_code.val = PREEMPTED
                return GoalOutcome(GoalVerdict.CANCELED, result)
            if self._cell.following:
                return None
            off = np.abs(self._cell.simulation.arm_joints - timed.positions[-1]).max()
            result.error_code.val = SUCCESS if off < TOLERANCE else CONTROL_FAILED
            return GoalOutcome(GoalVerdict.SUCCEEDED if off < TOLERANCE else GoalVerdict.ABORTED, result)

        return watch

    def _at_once(self, code: int) -> Watch:
        result = self._kind.Result()
        result.error_code.val = code
        return lambda _: GoalOutcome(GoalVerdict.ABORTED, result)


def boxes(scene: Any) -> list[Obstacle]:
    """The boxes of a planning scene's difference."""
    here = RobotToolPose(np.zeros(3), np.array((0.0, 0.0, 0.0, 1.0)))
    return [box_of(thing, here) for thing in scene.world.collision_objects if thing.operation == thing.ADD]


def box_of(thing: Any, frame: RobotToolPose) -> Obstacle:
    """A CollisionObject that is one upright box, given in a frame, in the base frame."""
    pose: RobotToolPose = pose_from_msg(thing.primitive_poses[0])
    x, y, z = (float(v) for v in frame.position + frame.rotation.apply(pose.position))
    yaw = float((frame.rotation * pose.rotation).as_euler("xyz")[2])
    along, across, up = (float(v) for v in thing.primitives[0].dimensions)
    return Obstacle(thing.id, (x, y, z), (along, across, up), yaw)
