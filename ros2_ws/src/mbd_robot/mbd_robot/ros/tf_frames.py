"""tf2's topics received without tf2_ros, which the PyPI wheels do not have."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from mbd_model.ros.conversions import time_from_msg
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from mbd_robot.frame_tree import FramePose, FrameTransform, FrameTree
from mbd_robot.ros.interfaces import interface

# As tf2_ros' listeners; the moving ones best effort, which receives from reliable publishers as well.
MOVING = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
FIXED = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class TfFrames:
    """Follows one frame in another.

    Args:
        node: that listens.
        base: frame in which the pose is wanted.
        frame: whose pose is wanted.
        moved: called when a transform between the two has come.

    Raises:
        MbdError: tf2_msgs is not installed.
    """

    def __init__(self, node: Node, base: str, frame: str, moved: Callable[[FramePose], None]) -> None:
        self._base, self._frame, self._moved = base, frame, moved
        self._tree = FrameTree()
        kind = interface("tf2_msgs", "msg", "TFMessage")
        node.create_subscription(kind, "/tf", lambda msg: self._on_transforms(msg, fixed=False), MOVING)
        node.create_subscription(kind, "/tf_static", lambda msg: self._on_transforms(msg, fixed=True), FIXED)

    def missing(self) -> str:
        """What is not known yet, for people; "" when the pose is."""
        if self._tree.pose(self._base, self._frame) is not None:
            return ""
        known = " > ".join(reversed(self._tree.chain(self._frame)))
        return (
            f"tf knows no way from '{self._base}' to '{self._frame}' (as yet {known}): is robot_state_publisher "
            "running, and does the profile name its frames?"
        )

    def _on_transforms(self, msg: Any, *, fixed: bool) -> None:
        changed = set()
        for transform in msg.transforms:
            t, q = transform.transform.translation, transform.transform.rotation
            made = FrameTransform(
                transform.header.frame_id,
                np.array((t.x, t.y, t.z)),
                np.array((q.x, q.y, q.z, q.w)),
                None if fixed else time_from_msg(transform.header.stamp),
            )
            if self._tree.put(transform.child_frame_id, made):
                changed.add(transform.child_frame_id.removeprefix("/"))
        between = {*self._tree.chain(self._frame), *self._tree.chain(self._base)}
        found = self._tree.pose(self._base, self._frame) if changed & between else None
        if found is not None and np.isfinite(found.stamp):
            self._moved(found)
