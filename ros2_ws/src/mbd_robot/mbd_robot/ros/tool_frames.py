"""Between the driver's tool frame and the suite's tool point, and poses as messages."""

from __future__ import annotations

import numpy as np
from geometry_msgs.msg import Point, Pose, Quaternion
from scipy.spatial.transform import Rotation

from mbd_robot.geometry import RobotToolPose
from mbd_robot.profiles.robot import ToolPoseProfile


def suite_pose(driver: RobotToolPose, profile: ToolPoseProfile) -> RobotToolPose:
    """The suite's tool for the driver's, both in the base frame."""
    rotation = driver.rotation
    return RobotToolPose(
        driver.position + rotation.apply(profile.offset), (rotation * Rotation.from_euler("z", profile.turn)).as_quat()
    )


def driver_pose(suite: RobotToolPose, profile: ToolPoseProfile) -> RobotToolPose:
    """The driver's tool for the suite's: the inverse of ``suite_pose``."""
    rotation = suite.rotation * Rotation.from_euler("z", -profile.turn)
    return RobotToolPose(suite.position - rotation.apply(profile.offset), rotation.as_quat())


def pose_to_msg(pose: RobotToolPose) -> Pose:
    """A pose in the base frame."""
    x, y, z = (float(v) for v in pose.position)
    i, j, k, w = (float(v) for v in pose.quaternion)
    return Pose(position=Point(x=x, y=y, z=z), orientation=Quaternion(x=i, y=j, z=k, w=w))


def pose_from_msg(msg: Pose) -> RobotToolPose:
    """A pose in the base frame; a quaternion of another length than 1 is scaled to it."""
    p, q = msg.position, msg.orientation
    quaternion = np.array((q.x, q.y, q.z, q.w))
    length = float(np.linalg.norm(quaternion))
    return RobotToolPose(np.array((p.x, p.y, p.z)), quaternion / length if length > 1e-9 else np.array((1.0, 0, 0, 0)))
