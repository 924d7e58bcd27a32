"""The arm told to move, in its driver's words: joint trajectories, MoveIt's goals, or poses of Kinova's driver."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import PoseStamped
from mbd_model.errors import MbdError
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.task import Future

from mbd_robot.geometry import RobotToolPose
from mbd_robot.profiles.robot import ArmInterface, RobotProfile
from mbd_robot.ros.interfaces import interface
from mbd_robot.ros.moving.driver_goal import DriverAction, GoalEnd
from mbd_robot.ros.moving.goal_end import ArmMotionEnd, ended
from mbd_robot.ros.moving.moveit_arm import Around, MoveGroupArm, Tool
from mbd_robot.ros.tool_frames import driver_pose, pose_to_msg

if TYPE_CHECKING:
    from mbd_robot.kinematics.chain import ArmChain
    from mbd_robot.motion.timing import TimedJoints

GOAL_TIME = 1.0  # [s] the arm may come late

Joints = Callable[[], tuple[float, ...] | None]


class ArmMotion(Protocol):
    """An arm as the robot node moves it."""

    def ready(self) -> str:
        """Name of what is missing, "" when the arm can be moved."""

    async def move(self, goal: RobotToolPose, speed: float) -> ArmMotionEnd:
        """Move the tool there, at most so fast [m/s]; raises MbdError where there is no way."""

    def cancel(self) -> None:
        """Stop the motion under way."""


class TrajectoryArm:
    """Plans joint trajectories and sends them to a FollowJointTrajectory action."""

    def __init__(self, node: Node, profile: RobotProfile, chain: ArmChain, joints: Joints, around: Around) -> None:
        # From pip, and needed only where trajectories are planned here.
        from mbd_robot.motion.planning import MotionPlanner

        self._node, self._profile, self._joints, self._around = node, profile, joints, around
        self._chain, self._planner = chain, MotionPlanner(chain)
        # A plan may take longer than the others wait for a sign of life: the node goes on meanwhile.
        self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="planning")
        kind = interface("control_msgs", "action", "FollowJointTrajectory")
        self._action = DriverAction(node, kind, profile.arm.action)

    def ready(self) -> str:
        """Name of what is missing, "" when the arm can be moved."""
        if not self._action.ready():
            return f"the action {self._action.name}"
        return "" if self._joints() is not None else "joint states of the whole arm"

    async def move(self, goal: RobotToolPose, speed: float) -> ArmMotionEnd:
        """Move the tool there, at most so fast [m/s]; raises MbdError where there is no way."""
        now = self._joints()
        if now is None:
            raise MbdError("no joint states of the whole arm: is the driver running?")
        timed = await self._planned(np.array(now), goal, speed)
        goal_msg = self._action.kind.Goal()
        fill_trajectory(goal_msg.trajectory, self._profile.arm.joints, timed)
        goal_msg.goal_time_tolerance = duration_of(GOAL_TIME)
        end = await self._action.run(goal_msg)
        return ended(end, self._action.name, trajectory_error(end))

    async def _planned(self, now: NDArray[np.float64], goal: RobotToolPose, speed: float) -> TimedJoints:
        """The plan, made in a thread of its own; raises as ``MotionPlanner.plan``."""
        around = self._around()
        self._chain.surround(around.obstacles)
        self._chain.hold(around.held)
        done: Future[None] = Future(executor=self._node.executor)
        work = self._thread.submit(self._planner.plan, now, goal, speed)
        work.add_done_callback(lambda _: done.set_result(None))
        await done
        return work.result()

    def cancel(self) -> None:
        """Stop the motion under way."""
        self._action.cancel()


class PoseArm:
    """Sends tool poses to Kinova's ArmPose action, whose driver finds the way by itself."""

    def __init__(self, node: Node, profile: RobotProfile) -> None:
        self._node, self._profile = node, profile
        self._action = DriverAction(node, interface("kinova_msgs", "action", "ArmPose"), profile.arm.action)

    def ready(self) -> str:
        """Name of what is missing, "" when the arm can be moved."""
        return "" if self._action.ready() else f"the action {self._action.name}"

    async def move(self, goal: RobotToolPose, speed: float) -> ArmMotionEnd:
        """Move the tool there; the driver's own speed counts."""
        del speed
        target = PoseStamped(pose=pose_to_msg(driver_pose(goal, self._profile.tool_pose)))
        target.header.frame_id = self._profile.base_frame
        target.header.stamp = self._node.get_clock().now().to_msg()
        end = await self._action.run(self._action.kind.Goal(pose=target))
        reason = "the arm stalled, or its driver was stopped (in/stop): start it again (in/start)"
        return ended(end, self._action.name, reason)

    def cancel(self) -> None:
        """Stop the motion under way."""
        self._action.cancel()


def arm_motion(
    node: Node,
    profile: RobotProfile,
    chain: ArmChain | None,
    *,
    joints: Joints,
    tool: Tool,
    around: Around,
    table_height: float,
) -> ArmMotion:
    """The arm of a profile.

    Args:
        node: the client's.
        profile: of the robot.
        chain: of its arm, which nobody else uses; needed where trajectories are planned here.
        joints: of the whole arm as last stated [rad].
        tool: where the suite's tool is.
        around: boxes to keep clear of, and what is in the hand.
        table_height: [m] of the table's top in the base frame.

    Raises:
        MbdError: the model is missing, or an interface is not installed.
    """
    if profile.arm.interface is ArmInterface.KINOVA_ARM_POSE:
        return PoseArm(node, profile)
    if profile.arm.interface is ArmInterface.MOVE_GROUP:
        return MoveGroupArm(node, profile, tool, around, table_height)
    if chain is None:
        raise MbdError(f"{profile.title} moves by joint trajectories, and there is no model of its arm yet")
    return TrajectoryArm(node, profile, chain, joints, around)


def fill_trajectory(msg: Any, joints: tuple[str, ...], timed: TimedJoints) -> None:
    """A trajectory as trajectory_msgs/JointTrajectory, to begin at once; it leaves out where the arm is already."""
    point_type = interface("trajectory_msgs", "msg", "JointTrajectoryPoint")
    msg.joint_names = list(joints)
    first = 1 if len(timed.times) > 1 else 0
    msg.points = [
        point_type(positions=p.tolist(), velocities=v.tolist(), time_from_start=duration_of(float(t)))
        for t, p, v in zip(timed.times[first:], timed.positions[first:], timed.velocities[first:], strict=True)
    ]


def duration_of(seconds: float) -> Duration:
    """[s] as a message."""
    whole = int(seconds)
    return Duration(sec=whole, nanosec=int((seconds - whole) * 1e9))


def trajectory_error(end: GoalEnd) -> str:
    """What a FollowJointTrajectory result says went wrong; "" for nothing."""
    if end.result is None or not end.aborted:
        return ""
    codes = {
        -1: "invalid goal",
        -2: "the joints' names are not the controller's",
        -3: "the trajectory lies in the past",
        -4: "the arm left the trajectory: something was in its way, or it was stopped",
        -5: "the arm did not arrive in time: something was in its way, or it was stopped",
    }
    code, text = int(end.result.error_code), str(end.result.error_string)
    why = codes.get(code, "stopped by its controller: an emergency or protective stop, or another controller")
    return f"{why}{f' ({text})' if text else ''}"
