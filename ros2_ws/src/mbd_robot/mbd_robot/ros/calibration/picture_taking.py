"""Takes pictures and tool poses for a calibration off the running robot and camera, whenever the hand rests again."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import PoseStamped
from mbd_model.errors import MbdError
from mbd_model.ros.guarded_node import GuardedNode
from mbd_model.ros.qos import MOTION, SENSOR
from mbd_model.ros.signals import StopRequest
from mbd_model.ros.spinning import spin_until_shutdown
from mbd_model.ros.starting.command_line import init_ros
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import CameraInfo, Image, JointState

from mbd_robot.profiles.camera import COLOR, DEPTH, INFO
from mbd_robot.ros.calibration.picture_collector import PictureCollector, PictureTaking
from mbd_robot.topics import JOINT_STATE, TOOL_POSE

SETTLED = 0.2  # [s] of rest before a picture counts: what was exposed while the hand came to rest is blurred
TOGETHER = 0.1  # [s] between stamps of colour and depth, or of a picture and the newest pose
AGAIN = 1.0  # [s] between two looks for the board where it was not seen
LATE = 20  # pictures in a row after which clocks differ, and nobody is only late
SILENT = 10.0  # [s] after which it is said what does not arrive


class CalibrationPictures(GuardedNode):
    """Subscribes to the suite's camera topics and tool pose.

    Args:
        taking: what is to be taken.
        say: takes each line for people.
        options: of rclpy's Node.

    Attributes:
        collector: keeps the pictures.
    """

    def __init__(self, taking: PictureTaking, say: Callable[[str], None], **options: Any) -> None:
        super().__init__("calibrate", **options)
        self.collector = PictureCollector(taking, say)
        self._began = time.monotonic()
        self.create_subscription(PoseStamped, TOOL_POSE, self.collector.on_pose, MOTION)
        self.create_subscription(Image, COLOR, self.collector.on_color, SENSOR)
        self.create_subscription(Image, DEPTH, self.collector.on_depth, SENSOR)
        self.create_subscription(CameraInfo, INFO, self.collector.on_info, SENSOR)
        self.create_subscription(JointState, JOINT_STATE, self.collector.on_joints, SENSOR)

    def complain(self) -> None:
        """Say once what does not arrive."""
        missing = self.collector.missing
        if missing and time.monotonic() - self._began > SILENT:
            self.collector.say_once(
                f"nothing arrives on {', '.join(missing)}: are the nodes robot and camera running, on this "
                "ROS_DOMAIN_ID? (./mbd run mbd_robot robot --ros-args -p robot:=NAME)"
            )


def take_pictures(taking: PictureTaking) -> int:
    """Take them until all are there, or Ctrl-C; the exit code: 0 when there is any."""
    stop = StopRequest()
    init_ros(args=[])
    node = CalibrationPictures(taking, _say)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    _say("move the hand so that the camera sees the board, and let it rest there; turn it each time (Ctrl-C ends)")

    def over() -> bool:
        node.complain()
        return bool(stop) or node.collector.done

    try:
        spin_until_shutdown(executor, over)
    finally:
        executor.shutdown()
        node.destroy_node()
    if not node.collector.count:
        raise MbdError(f"no picture was taken into {taking.folder}")
    _say(f"{node.collector.count} pictures in {taking.folder}; next: calibrate solve {taking.folder} --out FILE")
    return 0


def _say(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()
