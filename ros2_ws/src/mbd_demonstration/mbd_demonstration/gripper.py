"""What the gripper did, whichever way it became known."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class GripperAction(IntEnum):
    """Values equal mbd_msgs/WizardGripper."""

    OPEN = 1
    CLOSE = 2


@dataclass(frozen=True)
class GripperEvent:
    """The gripper opened or closed.

    Attributes:
        stamp: when [s].
        action: which of the two.
    """

    stamp: float
    action: GripperAction
