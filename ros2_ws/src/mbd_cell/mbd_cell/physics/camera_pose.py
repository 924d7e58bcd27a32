"""Where the cell's camera is, and its pose in MuJoCo's convention."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from mbd_model.camera.pose import CameraPose, pose_from_quaternion
from mbd_model.errors import MbdError
from scipy.spatial.transform import Rotation

# Above the table's far half, tilted by 7 degrees towards the robot: it sees all of the table in reach, with no part of
# the tucked arm before it. The image's right is the robot's right, its lower edge near the robot. Also in
# config/camera.yaml.
CELL_CAMERA_POSITION = (0.58, 0.0, 1.0)  # [m]
CELL_CAMERA_ORIENTATION = (0.70563015, -0.70563015, -0.0456738, 0.0456738)  # x, y, z, w
CELL_CAMERA = pose_from_quaternion(CELL_CAMERA_POSITION, CELL_CAMERA_ORIENTATION)

# Half a turn about the optical x axis: MuJoCo's cameras look along -z, with y up.
_MUJOCO_TO_OPTICAL = np.diag([1.0, -1.0, -1.0])


def surveyed_pose(position: Sequence[float], orientation: Sequence[float]) -> CameraPose:
    """The pose from x, y, z [m, base frame] and a quaternion x, y, z, w of the optical frame in the base frame.

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
    return pose_from_quaternion(position, orientation)


def mujoco_quaternion(pose: CameraPose) -> tuple[float, float, float, float]:
    """(w, x, y, z) of the MuJoCo camera frame (x right, y up, z backward)."""
    x, y, z, w = (float(v) for v in Rotation.from_matrix(pose.rotation @ _MUJOCO_TO_OPTICAL).as_quat())
    return (w, x, y, z)
