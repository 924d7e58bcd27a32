"""What the gripper did, whichever way it became known."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
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
        unsure: [s] a closing may have been that much earlier, an opening later: between two far samples, or while
            fingers arrived slowly at what gave way.
        level: of a closing, the share of the fingers' range at which they then rest; NaN where none was shallower.
    """

    stamp: float
    action: GripperAction
    unsure: float = field(default=0.0, compare=False)
    level: float = field(default=math.nan, compare=False)
