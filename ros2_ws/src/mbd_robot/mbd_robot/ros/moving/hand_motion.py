"""The hand told to open and to close, in its driver's words."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from mbd_model.stop import MotionError
from rclpy.node import Node

from mbd_robot.hand import arrived_open, is_holding
from mbd_robot.motion.standstill import Stated
from mbd_robot.profiles.robot import HandInterface, HandProfile
from mbd_robot.ros.interfaces import interface
from mbd_robot.ros.moving.arm_motion import duration_of
from mbd_robot.ros.moving.driver_goal import DriverAction, GoalEnd
from mbd_robot.ros.moving.rest import at_rest

SPEED = 0.1  # [m/s] of Franka's fingers
CLOSING_TIME = 1.5  # [s] of a hand that takes a trajectory
# Franka's grasp fails where the width found is not the one asked for, within this [m]: any is asked for.
ANY_WIDTH = 0.1
STILL = 0.01  # share of the hand's way by which its joints' statements differ where it stands

Goals = Callable[[Any, HandProfile, bool], Any]


@dataclass(frozen=True)
class HandMotionEnd:
    """How a motion of the hand ended.

    Attributes:
        success: the hand is open, or closed as far as it goes.
        holding: something is between the fingers.
        message: for people.
        code: why not, for the suite.
    """

    success: bool
    holding: bool = False
    message: str = ""
    code: MotionError = MotionError.NONE


class HandMotion:
    """One hand.

    Args:
        node: the client's.
        profile: of the hand.
        stated: mean position of its joints [rad or m] as last stated, None where it is not.
    """

    def __init__(self, node: Node, profile: HandProfile, stated: Callable[[], Stated | None]) -> None:
        self._node, self._profile, self._stated = node, profile, stated
        package, name, self._goal = _KINDS[profile.interface]
        self._close = DriverAction(node, interface(package, "action", name), profile.action)
        self._open = self._close
        if profile.interface is HandInterface.FRANKA_GRASP:
            self._open = DriverAction(node, interface(package, "action", "Move"), profile.action_open)

    def ready(self) -> str:
        """Name of what is missing, "" when the hand can be moved."""
        missing = next((a.name for a in (self._close, self._open) if not a.ready()), "")
        return f"the action {missing}" if missing else ""

    def cancel(self) -> None:
        """Stop the motion under way."""
        self._close.cancel()
        self._open.cancel()

    async def move(self, close: bool) -> HandMotionEnd:
        """Open or close it, and look at its joints then."""
        action = self._close if close else self._open
        name, end = action.name, await action.run(self._goal(action.kind, self._profile, close))
        if end.lost:
            text = f"the hand's driver is gone: nobody serves {name}"
            return HandMotionEnd(False, message=text, code=MotionError.DRIVER_LOST)
        if not end.accepted:
            text = f"{name} refused the goal: is the hand activated?"
            return HandMotionEnd(False, message=text, code=MotionError.PROTECTIVE_STOP)
        if end.canceled:
            return HandMotionEnd(False, message="stopped on request", code=MotionError.CANCELED)
        way = abs(self._profile.closed - self._profile.open)
        await at_rest(self._node, self._stated, STILL * way, self._profile.settle)
        return self._judged(end, close, name)

    def _judged(self, end: GoalEnd, close: bool, name: str) -> HandMotionEnd:
        """What the joints say counts, where they say something; the action's end where they do not."""
        stated = self._stated()
        position = None if stated is None else stated.values[0]
        stalled = bool(getattr(end.result, "stalled", False)) or (end.aborted and self._profile.abort_is_stall)
        if not end.succeeded and not (stalled and close):
            text = f"{name} gave the goal up: is the hand free to move?"
            return HandMotionEnd(False, message=text, code=MotionError.PROTECTIVE_STOP)
        if not close and position is not None and not arrived_open(position, self._profile):
            text = f"the hand stayed at {position:.3f}, not open"
            return HandMotionEnd(False, message=text, code=MotionError.NOT_REACHED)
        if not close:
            return HandMotionEnd(True)
        holding = stalled if position is None else is_holding(position, self._profile)
        return HandMotionEnd(True, holding, "holding something" if holding else "holding nothing")


def _command(hand: HandProfile, close: bool) -> float:
    return hand.command_closed if close else hand.command_open


def _gripper_command(kind: Any, hand: HandProfile, close: bool) -> Any:
    goal = kind.Goal()
    goal.command.position, goal.command.max_effort = _command(hand, close), hand.max_effort
    return goal


def _parallel_gripper_command(kind: Any, hand: HandProfile, close: bool) -> Any:
    goal = kind.Goal()
    goal.command.name = list(hand.joints[:1])
    goal.command.position, goal.command.effort = [_command(hand, close)], [hand.max_effort]
    return goal


def _fingers(kind: Any, hand: HandProfile, close: bool) -> Any:
    goal = kind.Goal()
    ticks = _command(hand, close)
    # A third finger that is not there must be asked for nothing, or the action ends late.
    goal.fingers.finger1, goal.fingers.finger2 = ticks, ticks
    goal.fingers.finger3 = ticks if len(hand.joints) > 2 else 0.0
    return goal


def _trajectory(kind: Any, hand: HandProfile, close: bool) -> Any:
    goal = kind.Goal()
    point = interface("trajectory_msgs", "msg", "JointTrajectoryPoint")
    goal.trajectory.joint_names = list(hand.joints)
    goal.trajectory.points = [
        point(positions=[_command(hand, close)] * len(hand.joints), time_from_start=duration_of(CLOSING_TIME))
    ]
    goal.goal_time_tolerance = duration_of(1.0)
    return goal


def _franka_grasp(kind: Any, hand: HandProfile, close: bool) -> Any:
    if not close:
        return kind.Goal(width=_command(hand, close), speed=SPEED)
    goal = kind.Goal(width=_command(hand, close), speed=SPEED, force=hand.max_effort)
    goal.epsilon.inner, goal.epsilon.outer = ANY_WIDTH, ANY_WIDTH
    return goal


_KINDS: dict[HandInterface, tuple[str, str, Goals]] = {
    HandInterface.GRIPPER_COMMAND: ("control_msgs", "GripperCommand", _gripper_command),
    HandInterface.PARALLEL_GRIPPER_COMMAND: ("control_msgs", "ParallelGripperCommand", _parallel_gripper_command),
    HandInterface.FOLLOW_JOINT_TRAJECTORY: ("control_msgs", "FollowJointTrajectory", _trajectory),
    HandInterface.KINOVA_FINGERS: ("kinova_msgs", "SetFingersPosition", _fingers),
    HandInterface.FRANKA_GRASP: ("franka_msgs", "Grasp", _franka_grasp),
}
