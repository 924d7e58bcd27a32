"""Where the camera is, in ROS optical and in MuJoCo conventions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from mbd_model.errors import MbdError


@dataclass(frozen=True)
class CameraPose:
    """camera2base: pose of the optical frame (x right, y down, z forward) in the robot base frame.

    Attributes:
        position: (x, y, z) [m].
        quaternion: (x, y, z, w), unit length.
    """

    position: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]

    @classmethod
    def from_numbers(cls, position: Sequence[float], orientation: Sequence[float]) -> CameraPose:
        """From [x, y, z] and [qx, qy, qz, qw].

        Raises:
            MbdError: not three and four finite numbers, or the quaternion is far from unit length.
        """
        if len(position) != 3 or len(orientation) != 4 or not all(map(math.isfinite, (*position, *orientation))):
            raise MbdError(
                "the camera's pose takes three finite numbers for its position and four for its orientation "
                f"(x, y, z, w); got {list(position)} and {list(orientation)}"
            )
        length = math.sqrt(sum(v * v for v in orientation))
        if abs(length - 1.0) > 1e-2:
            raise MbdError(f"camera orientation {list(orientation)} has length {length:.4f}, not 1; normalise it")
        x, y, z, w = (v / length for v in orientation)
        return cls((position[0], position[1], position[2]), (x, y, z, w))

    @property
    def mujoco_quaternion(self) -> tuple[float, float, float, float]:
        """(w, x, y, z) of the MuJoCo camera frame (x right, y up, z backward): half a turn about the optical x axis."""
        x, y, z, w = self.quaternion
        return (-x, w, z, -y)


# Above the table's far half, tilted by 7 degrees towards the robot: it sees all of the table in reach, with no part of
# the tucked arm before it. The image's right is the robot's right, its lower edge near the robot. Also in
# config/camera.yaml.
CELL_CAMERA = CameraPose((0.58, 0.0, 1.0), (0.70563015, -0.70563015, -0.0456738, 0.0456738))
