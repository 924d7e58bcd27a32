"""Where the tool is, by the profile: a topic, tf2, or the joints and the arm's model."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from geometry_msgs.msg import PoseStamped
from mbd_model.errors import MbdError
from mbd_model.ros.conversions import time_from_msg
from mbd_model.ros.qos import MOTION
from rclpy.node import Node
from rclpy.time import Time

from mbd_robot.geometry import RobotToolPose
from mbd_robot.profiles.robot import RobotProfile, ToolPoseSource
from mbd_robot.ros.tool_frames import pose_from_msg, suite_pose

if TYPE_CHECKING:
    from mbd_robot.kinematics.chain import ArmChain

# Takes a stamp [s] and the suite's tool pose.
OnPose = Callable[[float, RobotToolPose], None]


class ToolSource:
    """Gives the suite's tool pose as often as the driver does.

    Args:
        node: that listens.
        profile: of the robot.
        chain: of its arm; needed where the pose comes of the joints.
        on_pose: takes each.

    Raises:
        MbdError: tf2 is asked for and not installed.
    """

    def __init__(self, node: Node, profile: RobotProfile, chain: ArmChain | None, on_pose: OnPose) -> None:
        self._node, self._profile, self._on_pose = node, profile, on_pose
        self.chain = chain
        self._buffer: Any = None
        self._warned = False
        source = profile.tool_pose.source
        if source is ToolPoseSource.TOPIC:
            node.create_subscription(PoseStamped, profile.tool_pose.topic, self._on_topic, MOTION)
        elif source is ToolPoseSource.TF:
            self._listen_to_tf()

    def _listen_to_tf(self) -> None:
        try:
            from tf2_ros import Buffer, TransformListener
        except ImportError as error:
            raise MbdError(
                "tool_pose is tf but tf2_ros is not installed here: install it, or set the profile's source to joints"
            ) from error
        self._buffer = Buffer()
        self._listener = TransformListener(self._buffer, self._node)

    def _on_topic(self, msg: PoseStamped) -> None:
        frame = msg.header.frame_id
        if frame not in ("", self._profile.base_frame):
            if not self._warned:
                self._warned = True
                self._node.get_logger().error(
                    f"{self._profile.tool_pose.topic} is in frame '{frame}', and the profile's base_frame is "
                    f"'{self._profile.base_frame}': correct the one that is wrong; poses are passed over"
                )
            return
        pose = suite_pose(pose_from_msg(msg.pose), self._profile.tool_pose)
        self._on_pose(time_from_msg(msg.header.stamp), pose)

    def on_joints(self, stamp: float, joints: tuple[float, ...]) -> None:
        """The arm's joints have moved: where they or tf2 say where the tool is, this is when to look."""
        source = self._profile.tool_pose.source
        if source is ToolPoseSource.JOINTS and self.chain is not None:
            self._on_pose(stamp, self.chain.tool_pose(np.array(joints)))
        elif source is ToolPoseSource.TF and self._buffer is not None:
            base, frame = self._profile.base_frame, self._profile.tool_pose.frame
            if self._buffer.can_transform(base, frame, Time()):
                found = self._buffer.lookup_transform(base, frame, Time())
                t, q = found.transform.translation, found.transform.rotation
                pose = RobotToolPose(np.array((t.x, t.y, t.z)), np.array((q.x, q.y, q.z, q.w)))
                self._on_pose(time_from_msg(found.header.stamp), suite_pose(pose, self._profile.tool_pose))
