"""The hand's driver in the cell: what each action answers, and how a hand says that it holds something."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from mbd_robot.profiles.robot import HandInterface, RobotProfile
from mbd_robot.ros.interfaces import interface
from rclpy.node import Node

from mbd_cell.arm.hand import GripperCommand
from mbd_cell.ros.stand_in.goals import GoalOutcome, GoalVerdict, StandInAction, Watch
from mbd_cell.stage import Stage

# Gives the position that a goal asks for, in the unit of its action.
Asked = Callable[[Any], float]
# Gives the result for the hand's position (in that unit) and whether it stalled.
Answer = Callable[[Any, float, bool], GoalOutcome]


class StandInHand:
    """One hand.

    Args:
        node: the server's.
        profile: of the robot.
        stage: whose cell's hand it is.
    """

    def __init__(self, node: Node, profile: RobotProfile, stage: Stage) -> None:
        self._profile, self._stage, self._cell = profile, stage, stage.cell
        self.late = profile.stand_in.stall_late if profile.stand_in else 0.0
        hand = profile.hand
        package, name, asked, answer = _KINDS[hand.interface]
        kind = interface(package, "action", name)
        self.actions = [
            StandInAction(node, kind, hand.action, lambda goal: self._begin(kind, asked(goal), answer), lambda: "")
        ]
        if hand.interface is HandInterface.FRANKA_GRASP:
            move = interface("franka_msgs", "action", "Move")
            self.actions.append(
                StandInAction(
                    node, move, hand.action_open, lambda goal: self._begin(move, goal.width, _moved), lambda: ""
                )
            )

    def positions(self) -> dict[str, float]:
        """Of each of the hand's joints as its driver states it [rad or m]."""
        hand = self._profile.hand
        value = hand.open + self._closed * (hand.closed - hand.open)
        return dict.fromkeys(hand.joints, value)

    @property
    def _closed(self) -> float:
        """0 open .. 1 closed, of the fingers as they are."""
        model = self._cell.robot.hand
        mean = float(self._cell.simulation.finger_joints.mean())
        return min(1.0, max(0.0, (mean - model.open_angle) / (model.closed_angle - model.open_angle)))

    def _begin(self, kind: Any, asked: float, answer: Answer) -> Watch:
        hand = self._profile.hand
        close = abs(asked - hand.command_closed) < abs(asked - hand.command_open)
        heeded = self._stage.gripper(GripperCommand.CLOSE if close else GripperCommand.OPEN)
        settled_at: list[int] = []

        def watch(cancel: bool) -> GoalOutcome | None:
            where = hand.command_open + self._closed * (hand.command_closed - hand.command_open)
            if cancel:
                return GoalOutcome(GoalVerdict.CANCELED, answer(kind, where, False).result)
            if not heeded:
                return GoalOutcome(GoalVerdict.ABORTED, answer(kind, where, False).result)
            # The teacher goes on as soon as the hand has settled: time passes by itself.
            if not self._cell.hand_settled:
                return None
            stalled = close and self._cell.fingers_stopped
            settled_at.append(self._cell.time_ns)
            if stalled and self._cell.time_ns - settled_at[0] < self.late * 1e9 and self._cell.waiting_for is None:
                return None
            return answer(kind, where, stalled)

        return watch


def _gripper_command(kind: Any, position: float, stalled: bool) -> GoalOutcome:
    # gripper_action_controller with allow_stalling.
    result = kind.Result(position=position, effort=0.0, stalled=stalled, reached_goal=not stalled)
    return GoalOutcome(GoalVerdict.SUCCEEDED, result)


def _parallel(kind: Any, position: float, stalled: bool) -> GoalOutcome:
    result = kind.Result(stalled=stalled, reached_goal=not stalled)
    result.state.position = [position]
    return GoalOutcome(GoalVerdict.SUCCEEDED, result)


def _fingers(kind: Any, position: float, stalled: bool) -> GoalOutcome:
    # kinova_fingers_action.cpp aborts when the fingers stall.
    result = kind.Result()
    result.fingers.finger1 = result.fingers.finger2 = result.fingers.finger3 = position
    return GoalOutcome(GoalVerdict.ABORTED if stalled else GoalVerdict.SUCCEEDED, result)


def _trajectory(kind: Any, position: float, stalled: bool) -> GoalOutcome:
    del position
    if stalled:
        return GoalOutcome(GoalVerdict.ABORTED, kind.Result(error_code=-5, error_string="goal tolerance violated"))
    return GoalOutcome(GoalVerdict.SUCCEEDED, kind.Result())


def _last_position(goal: Any) -> float:
    return float(goal.trajectory.points[-1].positions[0])


def _moved(kind: Any, position: float, stalled: bool) -> GoalOutcome:
    del position, stalled
    return GoalOutcome(GoalVerdict.SUCCEEDED, kind.Result(success=True))


_KINDS: dict[HandInterface, tuple[str, str, Asked, Answer]] = {
    HandInterface.GRIPPER_COMMAND: (
        "control_msgs", "GripperCommand", lambda goal: float(goal.command.position), _gripper_command,
    ),
    HandInterface.PARALLEL_GRIPPER_COMMAND: (
        "control_msgs", "ParallelGripperCommand", lambda goal: float(goal.command.position[0]), _parallel,
    ),
    HandInterface.FOLLOW_JOINT_TRAJECTORY: (
        "control_msgs", "FollowJointTrajectory", _last_position, _trajectory,
    ),
    HandInterface.KINOVA_FINGERS: (
        "kinova_msgs", "SetFingersPosition", lambda goal: float(goal.fingers.finger1), _fingers,
    ),
    HandInterface.FRANKA_GRASP: ("franka_msgs", "Grasp", lambda goal: float(goal.width), _moved),
}  # fmt: skip
