"""Where objects can be: limits in the base frame."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from mbd_model.camera.pose import CameraPose
from mbd_model.errors import MbdError

from mbd_perception.frames.frame import FloatImage, RgbdFrame
from mbd_perception.segmentation.components import Mask

Range = tuple[float, float]
EVERYWHERE: Range = (-math.inf, math.inf)


@dataclass(frozen=True)
class Workspace:
    """Where objects can be [m, base frame]; what reaches out of it (the arm, a person) is not an object.

    Attributes:
        x, y, z: (lowest, highest) coordinate.
    """

    x: Range = EVERYWHERE
    y: Range = EVERYWHERE
    z: Range = EVERYWHERE

    def __post_init__(self) -> None:
        """Raises MbdError for an empty range."""
        for name in ("x", "y", "z"):
            low, high = getattr(self, name)
            if not low < high:
                raise MbdError(f"workspace {name} from {low} to {high} m is empty: give the lower number first")

    def contains(self, depth: FloatImage, frame: RgbdFrame, pose: CameraPose) -> Mask:
        """Which pixels with depth lie inside, (height, width) bool."""
        inside = depth > 0
        columns, rows = frame.camera.rays()
        for axis, (low, high) in enumerate((self.x, self.y, self.z)):
            if (low, high) == EVERYWHERE:
                continue
            a, b, c = pose.rotation[axis].astype(np.float32)
            coordinate = a * columns + (b * rows + c)
            coordinate *= depth
            offset = np.float32(pose.position[axis])
            inside &= (coordinate > np.float32(low) - offset) & (coordinate < np.float32(high) - offset)
        return inside
