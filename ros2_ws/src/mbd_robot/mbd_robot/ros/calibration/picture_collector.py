"""Keeps a picture with its tool pose whenever the hand rests somewhere new, of messages live or from a bag."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from geometry_msgs.msg import PoseStamped
from mbd_model.ros.conversions import time_from_msg
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo, Image, JointState

from mbd_robot.calibration.board.pattern import BoardPattern
from mbd_robot.calibration.board.views import BoardCorners, find_corners
from mbd_robot.calibration.errors import CalibrationError
from mbd_robot.calibration.pairs.pair import BoardMounting, CalibrationPair, PairSet
from mbd_robot.calibration.pairs.stillness import RestingPose, StillnessWatch
from mbd_robot.calibration.pairs.writing import PictureWriter
from mbd_robot.calibration.progress import progress
from mbd_robot.profiles.camera import COLOR, INFO
from mbd_robot.ros.calibration.image_messages import (
    depth_from_image,
    lens_from_info,
    rgb_from_image,
    transform_from_pose,
)
from mbd_robot.topics import TOOL_POSE

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
    board: BoardPattern
    mounting: BoardMounting
    count: int
    board_needed: bool = True
    table_height: float = 0.0


class PictureCollector:
    """Takes the messages of camera and robot, in the order of their stamps, and writes what is worth keeping.

    Args:
        taking: what is to be taken.
        say: takes each line for people.
    """

    def __init__(self, taking: PictureTaking, say: Callable[[str], None]) -> None:
        self._taking, self._say = taking, say
        self._watch = StillnessWatch()
        self._writer: PictureWriter | None = None
        self._info: CameraInfo | None = None
        self._depth: Image | None = None
        self._joints: dict[str, float] = {}
        self._pairs: list[CalibrationPair] = []
        self._apart = 0  # pictures in a row whose stamps are not those of the poses
        self._base, self._looked, self._complained = "", -np.inf, ""
        self._received: set[str] = set()

    @property
    def count(self) -> int:
        """Pictures taken."""
        return self._writer.count if self._writer else 0

    @property
    def done(self) -> bool:
        """Whether all are taken."""
        return self.count >= self._taking.count

    @property
    def missing(self) -> list[str]:
        """Topics of which nothing came yet, of those that are needed."""
        return [name for name in (TOOL_POSE, COLOR, INFO) if name not in self._received]

    def say_once(self, words: str) -> None:
        """Say it, unless it was the last thing said."""
        if words != self._complained:
            self._complained = words
            self._say(words)

    def on_pose(self, msg: PoseStamped) -> None:
        """The tool is there."""
        self._received.add(TOOL_POSE)
        self._base = msg.header.frame_id
        self._watch.pose(time_from_msg(msg.header.stamp), transform_from_pose(msg.pose))

    def on_info(self, msg: CameraInfo) -> None:
        """The lens."""
        self._received.add(INFO)
        self._info = msg

    def on_depth(self, msg: Image) -> None:
        """Depth, kept for the next picture."""
        self._depth = msg

    def on_joints(self, msg: JointState) -> None:
        """Positions of some joints."""
        self._joints.update(zip(msg.name, (float(v) for v in msg.position), strict=False))

    def on_color(self, msg: Image) -> None:
        """A picture: taken where the hand rests again."""
        self._received.add(COLOR)
        stamp, resting = time_from_msg(msg.header.stamp), self._watch.resting()
        if self.done or self._info is None or resting is None or not self._watch.is_new(resting.tool):
            return
        if not resting.since + SETTLED <= stamp <= resting.until + TOGETHER:
            self._apart = self._apart + 1 if abs(stamp - resting.until) > AGAIN else 0
            if self._apart > LATE:
                self.say_once(
                    f"the stamps of pictures and of tool poses differ by {stamp - resting.until:+.1f} s; expected one "
                    "clock: synchronise the machines (chrony)"
                )
            return
        self._apart = 0
        if 0.0 <= stamp - self._looked < AGAIN:
            return
        self._looked = stamp
        try:
            self._take(msg, self._info, stamp, resting)
        except CalibrationError as error:
            self.say_once(str(error))

    def _take(self, msg: Image, info: CameraInfo, stamp: float, resting: RestingPose) -> None:
        picture, lens = rgb_from_image(msg), lens_from_info(info)
        if (lens.pinhole.width, lens.pinhole.height) != (msg.width, msg.height):
            raise CalibrationError(
                f"camera_info is for {lens.pinhole.width} x {lens.pinhole.height} px, pictures have {msg.width} x "
                f"{msg.height}; expected those of the colour camera"
            )
        corners = find_corners(picture, self._taking.board, lens)
        if corners is None and self._taking.board_needed:
            self.say_once("the hand rests, and the board is not seen: turn it to the camera, whole, without glare")
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
