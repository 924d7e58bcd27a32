"""Takes pictures and tool poses for a calibration off the running robot and camera, whenever the hand rests anew."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped
from mbd_model.errors import MbdError
from mbd_model.ros.command_line import init_ros
from mbd_model.ros.conversions import time_from_msg
from mbd_model.ros.guarded_node import GuardedNode
from mbd_model.ros.qos import MOTION, SENSOR
from mbd_model.ros.signals import StopRequest
from mbd_model.ros.spinning import spin_until_shutdown
from numpy.typing import NDArray
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import CameraInfo, Image, JointState

from mbd_robot.calibration.board.printed import PrintedBoard
from mbd_robot.calibration.board.views import BoardCorners, find_corners
from mbd_robot.calibration.errors import CalibrationError
from mbd_robot.calibration.pairs.pair import BoardMounting, CalibrationPair, PairSet
from mbd_robot.calibration.pairs.stillness import RestingPose, StillnessWatch
from mbd_robot.calibration.pairs.writing import PictureWriter
from mbd_robot.calibration.progress import progress
from mbd_robot.profiles.camera import COLOR, DEPTH, INFO
from mbd_robot.ros.calibration.image_messages import (
    depth_from_image,
    lens_from_info,
    rgb_from_image,
    transform_from_pose,
)
from mbd_robot.topics import JOINT_STATE, TOOL_POSE

SETTLED = 0.2  # [s] of rest before a picture counts: what was exposed while the hand came to rest is blurred
TOGETHER = 0.1  # [s] between stamps of colour and depth, or of a picture and the newest pose
AGAIN = 1.0  # [s] between two looks for the board where it was not seen
LATE = 20  # pictures in a row after which clocks differ, and nobody is only late
SILENT = 10.0  # [s] after which it is said what does not arrive


@dataclass(frozen=True)
class PictureTaking:
    """What is to be taken.

    Attributes:
        folder: new, for pictures and poses.
        board: to look for.
        mounting: where it is.
        count: of pictures.
        board_needed: whether a picture without the board is passed over.
        table_height: [m] in the base frame, where the error is stated.
    """

    folder: Path
    board: PrintedBoard
    mounting: BoardMounting
    count: int
    board_needed: bool = True
    table_height: float = 0.0


class CalibrationPictures(GuardedNode):
    """Hears the suite's camera topics and tool pose; writes a picture whenever the hand rests somewhere new.

    Args:
        taking: what is to be taken.
        say: takes each line for people.
        options: of rclpy's Node.
    """

    def __init__(self, taking: PictureTaking, say: Callable[[str], None], **options: Any) -> None:
        super().__init__("calibrate", **options)
        self._taking, self._say = taking, say
        self._watch = StillnessWatch()
        self._writer: PictureWriter | None = None
        self._info: CameraInfo | None = None
        self._depth: Image | None = None
        self._joints: dict[str, float] = {}
        self._pairs: list[CalibrationPair] = []
        self._apart = 0  # pictures in a row whose stamps are not those of the poses
        self._base, self._looked, self._complained = "", -np.inf, ""
        self._heard: set[str] = set()
        self._began = time.monotonic()
        self.create_subscription(PoseStamped, TOOL_POSE, self._on_pose, MOTION)
        self.create_subscription(Image, COLOR, self._on_color, SENSOR)
        self.create_subscription(Image, DEPTH, self._on_depth, SENSOR)
        self.create_subscription(CameraInfo, INFO, self._on_info, SENSOR)
        self.create_subscription(JointState, JOINT_STATE, self._on_joints, SENSOR)

    @property
    def count(self) -> int:
        """Pictures taken."""
        return self._writer.count if self._writer else 0

    @property
    def done(self) -> bool:
        """Whether all are taken."""
        return self.count >= self._taking.count

    def complain(self) -> None:
        """Say once what does not arrive."""
        missing = [name for name in (TOOL_POSE, COLOR, INFO) if name not in self._heard]
        if missing and time.monotonic() - self._began > SILENT:
            self._say_once(
                f"nothing arrives on {', '.join(missing)}: are the nodes robot and camera running, on this "
                "ROS_DOMAIN_ID? (./mbd run mbd_robot robot --ros-args -p robot:=NAME)"
            )

    def _say_once(self, words: str) -> None:
        if words != self._complained:
            self._complained = words
            self._say(words)

    def _on_pose(self, msg: PoseStamped) -> None:
        self._heard.add(TOOL_POSE)
        self._base = msg.header.frame_id
        self._watch.pose(time_from_msg(msg.header.stamp), transform_from_pose(msg.pose))

    def _on_info(self, msg: CameraInfo) -> None:
        self._heard.add(INFO)
        self._info = msg

    def _on_depth(self, msg: Image) -> None:
        self._depth = msg

    def _on_joints(self, msg: JointState) -> None:
        self._joints.update(zip(msg.name, (float(v) for v in msg.position), strict=False))

    def _on_color(self, msg: Image) -> None:
        self._heard.add(COLOR)
        stamp, resting = time_from_msg(msg.header.stamp), self._watch.resting()
        if self.done or self._info is None or resting is None or not self._watch.is_new(resting.tool):
            return
        if not resting.since + SETTLED <= stamp <= resting.until + TOGETHER:
            self._apart = self._apart + 1 if abs(stamp - resting.until) > AGAIN else 0
            if self._apart > LATE:
                self._say_once(
                    f"the stamps of pictures and of tool poses differ by {stamp - resting.until:+.1f} s; expected one "
                    "clock: synchronise the machines (chrony)"
                )
            return
        self._apart = 0
        if 0.0 <= stamp - self._looked < AGAIN:
            return
        self._looked = stamp
        try:
            self._take(msg, stamp, resting)
        except CalibrationError as error:
            self._say_once(str(error))

    def _take(self, msg: Image, stamp: float, resting: RestingPose) -> None:
        picture, lens = rgb_from_image(msg), lens_from_info(self._info)
        if (lens.pinhole.width, lens.pinhole.height) != (msg.width, msg.height):
            raise CalibrationError(
                f"camera_info is for {lens.pinhole.width} x {lens.pinhole.height} px, pictures have {msg.width} x "
                f"{msg.height}; expected those of the colour camera"
            )
        corners = find_corners(picture, self._taking.board, lens)
        if corners is None and self._taking.board_needed:
            self._say_once("the hand rests, and the board is not seen: turn it to the camera, whole, without glare")
            return
        if self._writer is None:
            frames = (self._base, msg.header.frame_id)
            self._writer = PictureWriter(
                self._taking.folder, self._taking.board, self._taking.mounting, frames, lens
            )  # fmt: skip
        name = self._writer.add(picture, resting.tool, self._depth_of(stamp, resting), dict(self._joints))
        self._watch.took(resting.tool)
        self._complained = ""
        self._say(f"{name} ({self.count} of {self._taking.count}): {self._told(name, resting, corners)}")
        if corners is not None and not self.done:
            given = PairSet(self._taking.mounting, self._taking.board, lens, tuple(self._pairs))
            self._say(f"  {progress(given, self._taking.table_height)}")

    def _told(self, name: str, resting: RestingPose, corners: BoardCorners | None) -> str:
        if corners is None:
            return "without the board"
        self._pairs.append(CalibrationPair(name, resting.tool, corners))
        return f"{len(corners.numbers)} of {len(self._taking.board.corners)} corners"

    def _depth_of(self, stamp: float, resting: RestingPose) -> NDArray[np.float32] | None:
        """Of this rest, if not of this moment: nothing moves meanwhile."""
        if self._depth is None:
            return None
        taken = time_from_msg(self._depth.header.stamp)
        if taken < resting.since or abs(taken - stamp) > AGAIN:
            return None
        return depth_from_image(self._depth)


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
        return bool(stop) or node.done

    try:
        spin_until_shutdown(executor, over)
    finally:
        executor.shutdown()
        node.destroy_node()
    if not node.count:
        raise MbdError(f"no picture was taken into {taking.folder}")
    _say(f"{node.count} pictures in {taking.folder}; next: calibrate solve {taking.folder} --out FILE")
    return 0


def _say(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()
