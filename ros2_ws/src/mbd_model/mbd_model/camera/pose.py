"""Where the camera stands: the rigid transform camera2base of its optical frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mbd_model.errors import MbdError

Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class CameraPose:
    """The transform camera2base, p_base = rotation @ p_camera + position.

    Attributes:
        rotation: (3, 3); columns are the optical frame's x (right), y (down), z (forward) in the base frame.
        position: (3,) of the optical centre [m, base frame].
    """

    rotation: Matrix = field(default_factory=lambda: np.eye(3))
    position: Matrix = field(default_factory=lambda: np.zeros(3))

    @property
    def up_in_camera(self) -> Matrix:
        """(3,) unit vector of the base frame's z, written in the optical frame."""
        up: Matrix = self.rotation[2]
        return up

    def to_base(self, points: Matrix) -> Matrix:
        """(n, 3) points [m, optical frame] in the base frame [m]."""
        moved: Matrix = points @ self.rotation.T + self.position
        return moved


def pose_from_quaternion(position: Sequence[float], quaternion: Sequence[float]) -> CameraPose:
    """A pose from position (x, y, z) [m] and quaternion (x, y, z, w) of the optical frame, in the base frame.

    Raises:
        MbdError: wrong lengths, numbers that are not finite, or a quaternion of length zero.
    """
    if len(position) != 3 or not np.isfinite(position).all():
        raise MbdError(f"camera_position {list(position)} is not three finite numbers [m]; give x, y, z")
    if len(quaternion) != 4 or not np.isfinite(quaternion).all():
        raise MbdError(f"camera_orientation {list(quaternion)} is not four finite numbers; give x, y, z, w")
    length = float(np.linalg.norm(quaternion))
    if length < 1e-6:
        raise MbdError("camera_orientation has length 0; give a quaternion x, y, z, w, such as 0, 0, 0, 1")
    x, y, z, w = np.asarray(quaternion, dtype=np.float64) / length
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    return CameraPose(rotation=rotation, position=np.asarray(position, dtype=np.float64))


def pose_above_plane(normal: Matrix, offset: float) -> CameraPose:
    """A pose for a camera nobody surveyed: the table is the plane z = 0, and the camera looks along +x.

    Args:
        normal: (3,) unit normal of the table, towards the camera, optical frame.
        offset: d of normal . p + d = 0 [m]: the camera's height above the table.

    Returns:
        The transform from the optical frame into a table frame whose origin lies under the camera.
    """
    up = np.asarray(normal, dtype=np.float64)
    forward = np.array([0.0, 0.0, 1.0])
    forward = forward - forward @ up * up
    if np.linalg.norm(forward) < 1e-3:  # looking straight down: the top of the picture is "away"
        forward = np.array([0.0, -1.0, 0.0]) + up[1] * up
    forward = forward / np.linalg.norm(forward)
    rotation = np.stack([forward, np.cross(up, forward), up])
    return CameraPose(rotation=rotation, position=np.array([0.0, 0.0, float(offset)]))
