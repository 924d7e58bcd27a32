"""What the robot is commanded to do: move its tool somewhere, fingers down or tilted, open or close its hand."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from mbd_model.objects import Scene
from mbd_model.stop import MotionError


def turned(x: float, y: float, angle: float) -> tuple[float, float]:
    """The vector (x, y) [m] turned by an angle [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    return c * x - s * y, s * x + c * y


def turn_between(start: float, end: float, period: float = 2 * math.pi) -> float:
    """The shortest turn [rad] from one angle to another that means the same after ``period``."""
    return math.remainder(end - start, period)


@dataclass(frozen=True)
class ToolGoal:
    """Where the tool is to be, its fingers down, or tilted from there.

    Attributes:
        x, y, z: [m, robot base frame]
        yaw: [rad] turn of the hand about the vertical.
        tilt: [rad] turn about the tool's x axis, its fingertips towards the tool's +y side; 0: straight down.
    """

    x: float
    y: float
    z: float
    yaw: float
    tilt: float = 0.0

    @property
    def quaternion(self) -> tuple[float, float, float, float]:
        """(x, y, z, w) of the tool: z along the fingers, down but for the tilt; x turned by the yaw."""
        c, s, u, v = math.cos(self.yaw / 2), math.sin(self.yaw / 2), math.cos(self.tilt / 2), math.sin(self.tilt / 2)
        return c * u, s * u, s * v, c * v

    def at_height(self, z: float) -> ToolGoal:
        """The same above or below, at a height [m]."""
        return replace(self, z=z)


def goal_of(position: tuple[float, float, float], quaternion: tuple[float, float, float, float]) -> ToolGoal:
    """The goal a pose (position [m], quaternion x, y, z, w) comes nearest to: its heading and tilt about x are kept."""
    x, y, z, w = quaternion
    yaw = math.atan2(2 * (x * y + w * z), 1 - 2 * (y * y + z * z))
    along = (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y))  # the tool's z axis
    aside = turned(along[0], along[1], -yaw)[1]
    return ToolGoal(*position, yaw, math.atan2(-aside, -along[2]))


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
