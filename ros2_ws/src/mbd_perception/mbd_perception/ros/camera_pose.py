"""Where the perception node gets the camera's pose from: parameters, tf2 where it is installed, or nowhere."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mbd_model.camera.pose import CameraPose, pose_from_quaternion
from mbd_model.errors import MbdError
from rclpy.node import Node
from rclpy.time import Time

from mbd_perception.config import known_pose


class FixedPose:
    """A pose that is known beforehand, or None when it is to be worked out from the table."""

    def __init__(self, pose: CameraPose | None) -> None:
        self._pose = pose

    def of(self, camera_frame: str) -> CameraPose | None:
        """The pose, whatever the camera's frame is called."""
        del camera_frame
        return self._pose


class TfPose:
    """The pose tf2 knows; raises MbdError when tf2_ros is not installed (the PyPI wheels have none)."""

    def __init__(self, node: Node, base_frame: str) -> None:
        try:
            from tf2_ros import Buffer, TransformListener
        except ImportError as error:
            raise MbdError(
                "camera_pose is 'tf' but tf2_ros is not installed here: install it, or set camera_pose to 'parameter' "
                "and give camera_position and camera_orientation"
            ) from error
        self._base_frame = base_frame
        self._buffer: Any = Buffer()
        self._listener = TransformListener(self._buffer, node)

    def of(self, camera_frame: str) -> CameraPose:
        """The newest camera2base; raises MbdError when tf2 does not know it."""
        if not self._buffer.can_transform(self._base_frame, camera_frame, Time()):
            raise MbdError(
                f"tf2 knows no transform from '{camera_frame}' to '{self._base_frame}': publish it "
                "(static_transform_publisher), or set camera_pose to 'parameter'"
            )
        transform = self._buffer.lookup_transform(self._base_frame, camera_frame, Time()).transform
        t, q = transform.translation, transform.rotation
        return pose_from_quaternion((t.x, t.y, t.z), (q.x, q.y, q.z, q.w))


def pose_source(node: Node, values: Mapping[str, Any]) -> FixedPose | TfPose:
    """The source that the node's parameters ask for; raises MbdError for a pose that cannot be."""
    if values["camera_pose"] == "tf":
        return TfPose(node, values["base_frame"])
    return FixedPose(known_pose(values))
