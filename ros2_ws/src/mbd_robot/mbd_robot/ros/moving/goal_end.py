"""How a motion of the arm ended, of a goal's end at its driver."""

from __future__ import annotations

from dataclasses import dataclass

from mbd_model.stop import MotionError

from mbd_robot.ros.moving.driver_goal import GoalEnd


@dataclass(frozen=True)
class ArmMotionEnd:
    """How a motion of the arm ended.

    Attributes:
        success: the driver says the arm is there.
        message: why not, for people.
        code: why not, for the suite.
    """

    success: bool
    message: str = ""
    code: MotionError = MotionError.NONE


def ended(end: GoalEnd, name: str, reason: str) -> ArmMotionEnd:
    """A goal's end as a motion's."""
    if end.lost:
        text = f"the arm's driver is gone: nobody serves {name}"
        return ArmMotionEnd(False, text, MotionError.DRIVER_LOST)
    if not end.accepted:
        text = f"{name} refused the goal: is its controller active, and the arm in the right mode?"
        return ArmMotionEnd(False, text, MotionError.PROTECTIVE_STOP)
    if end.canceled:
        return ArmMotionEnd(False, "stopped on request", MotionError.CANCELED)
    if end.succeeded:
        return ArmMotionEnd(True)
    # A driver that gives up does not say whether it was an emergency stop or something in its way.
    return ArmMotionEnd(False, reason or f"{name} gave the goal up", MotionError.PROTECTIVE_STOP)
