"""What the robot is commanded to do: move its tool somewhere with the fingers down, open or close its hand."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

from mbd_model.objects import Scene


def turned(x: float, y: float, angle: float) -> tuple[float, float]:
    """The vector (x, y) [m] turned by an angle [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    return c * x - s * y, s * x + c * y


def turn_between(start: float, end: float, period: float = 2 * math.pi) -> float:
    """The shortest turn [rad] from one angle to another that means the same after ``period``."""
    return math.remainder(end - start, period)


@dataclass(frozen=True)
class ToolGoal:
    """Tool position (x, y, z) [m, robot base frame] and turn of the hand about the vertical [rad], fingers down."""

    x: float
    y: float
    z: float
    yaw: float

    @property
    def quaternion(self) -> tuple[float, float, float, float]:
        """(x, y, z, w) of the tool: z along the fingers, down; x turned by the yaw."""
        return math.cos(self.yaw / 2), math.sin(self.yaw / 2), 0.0, 0.0

    def at_height(self, z: float) -> ToolGoal:
        """The same above or below, at a height [m]."""
        return ToolGoal(self.x, self.y, z, self.yaw)


def goal_of(position: tuple[float, float, float], quaternion: tuple[float, float, float, float]) -> ToolGoal:
    """The goal a pose (position [m], quaternion x, y, z, w) comes nearest to: its heading is kept, its tilt is not."""
    x, y, z, w = quaternion
    yaw = math.atan2(2 * (x * y + w * z), 1 - 2 * (y * y + z * z))
    return ToolGoal(*position, yaw)


@dataclass(frozen=True)
class MoveTo:
    """Move the tool straight to a goal, at a speed [m/s]."""

    goal: ToolGoal
    speed: float


@dataclass(frozen=True)
class Grip:
    """Close the hand, or open it."""

    close: bool


@dataclass(frozen=True)
class Look:
    """Look at the table, with the arm out of the camera's view."""


Motion = MoveTo | Grip | Look


class MotionError(IntEnum):
    """Why a motion failed; values equal mbd_msgs/MoveTool and MoveGripper."""

    NONE = 0
    NOT_REACHED = 1
    EMERGENCY_STOP = 2
    PROTECTIVE_STOP = 3
    DRIVER_LOST = 4
    CANCELED = 5


@dataclass(frozen=True)
class Ended:
    """How a motion ended.

    Attributes:
        success: the tool arrived, or the fingers did what they were commanded.
        holding: something is between the fingers; of a Grip only.
        message: why not, for people.
        reached: where the tool is now, None when that is not known.
        error: why not; NONE of a failure: the arm did not state it.
        seen: what is on the table; of a Look only.
    """

    success: bool
    holding: bool = False
    message: str = ""
    reached: ToolGoal | None = None
    error: MotionError = MotionError.NONE
    seen: Scene | None = None

    @property
    def stops(self) -> bool:
        """Everything stands from now on: it failed, and not only by not getting there."""
        return not self.success and self.error is not MotionError.NOT_REACHED
