"""Where the camera stands, as every node that must know it is configured."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mbd_model.camera.pose import CameraPose, pose_from_quaternion
from mbd_model.parameters import ParameterSpec

CAMERA_POSITION = ParameterSpec(
    "camera_position", (0.6, 0.0, 1.2), "Optical centre x, y, z in the robot's base frame.", "m"
)
CAMERA_ORIENTATION = ParameterSpec(
    "camera_orientation",
    (-0.7071067811865476, 0.7071067811865476, 0.0, 0.0),
    "Quaternion x, y, z, w of the optical frame (x right, y down, z forward) in the base frame.",
)


def camera_pose(values: Mapping[str, Any]) -> CameraPose:
    """camera2base of a node's values of these two; raises MbdError when the quaternion is none."""
    return pose_from_quaternion(values[CAMERA_POSITION.name], values[CAMERA_ORIENTATION.name])
