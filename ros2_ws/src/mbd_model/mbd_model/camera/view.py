"""Where points of the robot's frame appear in a camera's picture (pinhole, no distortion)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mbd_model.camera.pose import CameraPose, pose_from_quaternion

Points = NDArray[np.float64]


@dataclass(frozen=True)
class CameraView:
    """A camera that is looked through.

    Attributes:
        intrinsics: (fx, fy, cx, cy) [px].
        size: (width, height) of its picture [px].
        pose: camera2base.
    """

    intrinsics: tuple[float, float, float, float]
    size: tuple[int, int]
    pose: CameraPose

    @classmethod
    def from_parameters(
        cls,
        intrinsics: Sequence[float],
        size: tuple[int, int],
        position: Sequence[float],
        orientation: Sequence[float],
    ) -> CameraView:
        """From numbers as parameters and camera_info give them.

        Args:
            intrinsics: fx, fy, cx, cy [px].
            size: (width, height) [px].
            position: x, y, z of the optical centre [m, base frame].
            orientation: quaternion x, y, z, w of the optical frame in the base frame.

        Raises:
            MbdError: the pose is none.
        """
        fx, fy, cx, cy = (float(v) for v in intrinsics)
        return cls((fx, fy, cx, cy), size, pose_from_quaternion(position, orientation))

    def project(self, points: Points) -> Points:
        """(n, 2) pixel coordinates (u right, v down) of (n, 3) points [m, base frame]; NaN behind the camera."""
        seen = (np.asarray(points, dtype=np.float64) - self.pose.position) @ self.pose.rotation
        depth = np.where(seen[:, 2] > 1e-6, seen[:, 2], np.nan)
        fx, fy, cx, cy = self.intrinsics
        return np.stack([fx * seen[:, 0] / depth + cx, fy * seen[:, 1] / depth + cy], axis=1)
