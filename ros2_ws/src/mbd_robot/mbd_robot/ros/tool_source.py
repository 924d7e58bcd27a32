"""Where the tool is, by the profile: a topic, tf2, or the joints and the arm's model."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from geometry_msgs.msg import PoseStamped
from mbd_model.ros.conversions import time_from_msg
from mbd_model.ros.qos import MOTION
from rclpy.node import Node

from mbd_robot.frame_tree import FramePose
from mbd_robot.geometry import RobotToolPose
from mbd_robot.profiles.robot import RobotProfile, ToolPoseSource
from mbd_robot.ros.tf_frames import TfFrames
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

    Attributes:
        by_joints: the joints say where the tool is.

    Raises:
        MbdError: tf is asked for, and its messages are not installed.
    """

    def __init__(self, node: Node, profile: RobotProfile, chain: ArmChain | None, on_pose: OnPose) -> None:
        self._node, self._profile, self._on_pose = node, profile, on_pose
        self.chain = chain
        self._warned = False
        self._frames: TfFrames | None = None
        source = profile.tool_pose
        self.by_joints = source.source is ToolPoseSource.JOINTS
        if source.source is ToolPoseSource.TOPIC:
            node.create_subscription(PoseStamped, source.topic, self._on_topic, MOTION)
        elif source.source is ToolPoseSource.TF:
            self._frames = TfFrames(node, profile.base_frame, source.frame, self._on_frame)

    def missing(self) -> str:
        """Why there is no pose yet, for people; "" where there is, or it is on its way."""
        return "" if self._frames is None else self._frames.missing()

    def _on_frame(self, found: FramePose) -> None:
        self._on_pose(found.stamp, suite_pose(found.pose, self._profile.tool_pose))

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
        """The arm's joints have moved: where they say where the tool is, this is when to look."""
        if self.by_joints and self.chain is not None:
            self._on_pose(stamp, self.chain.tool_pose(np.array(joints)))
