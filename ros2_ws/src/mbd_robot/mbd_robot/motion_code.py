"""Why a motion failed, in the codes of mbd_msgs/MoveTool and mbd_msgs/MoveGripper."""

from __future__ import annotations

from enum import IntEnum


class MotionCode(IntEnum):
    """Only NOT_REACHED is tried again by itself; after the others a person lets the robot go on."""

    NONE = 0
    NOT_REACHED = 1
    EMERGENCY_STOP = 2
    PROTECTIVE_STOP = 3
    DRIVER_LOST = 4
    CANCELED = 5
