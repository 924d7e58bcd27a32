"""`calibrate take` on real messages: pictures and poses as robot and camera publish them, one where the hand rests."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import rclpy
from board_scene import BOARD, LENS
from calibration_messages import image, pictured, pose_stamped
from geometry_msgs.msg import PoseStamped
from mbd_model.ros.conversions import header
from mbd_model.ros.qos import SENSOR
from mbd_robot.calibration.pairs.pair import BoardMounting
from mbd_robot.calibration.pairs.reading import read_pictures
from mbd_robot.calibration.transforms import Transforms, transform
from mbd_robot.profiles.camera import COLOR, DEPTH, INFO
from mbd_robot.ros.calibration.image_messages import depth_from_image, rgb_from_image
from mbd_robot.ros.calibration.picture_collector import PictureTaking
from mbd_robot.ros.calibration.picture_taking import CalibrationPictures
from mbd_robot.topics import TOOL_POSE
from numpy.typing import NDArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import CameraInfo, Image

LIMIT = 60.0  # [s] of a failure


class Drivers:
    """What robot and camera publish, beside the node under test, in one executor."""

    def __init__(self, domain: int, taking: PictureTaking) -> None:
        self.context = rclpy.Context()
        rclpy.init(context=self.context, args=[], domain_id=domain)
        self.said: list[str] = []
        self.node = Node("drivers", context=self.context)
        self.taking = CalibrationPictures(taking, self.said.append, context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.executor.add_node(self.taking)
        self.tool = self.node.create_publisher(PoseStamped, TOOL_POSE, SENSOR)
        self.color = self.node.create_publisher(Image, COLOR, SENSOR)
        self.depth = self.node.create_publisher(Image, DEPTH, SENSOR)
        self.info = self.node.create_publisher(CameraInfo, INFO, SENSOR)
        self.stamp = 100.0
        self.until(lambda: all(p.get_subscription_count() for p in (self.tool, self.color, self.depth, self.info)))

    def until(self, true: Callable[[], bool]) -> bool:
        end = time.monotonic() + LIMIT
        while not true():
            if time.monotonic() > end:
                return False
            for _ in range(8):  # all that was published at once
                self.executor.spin_once(timeout_sec=0.01)
        return True

    def rest(self, tool: Transforms, picture: NDArray[np.uint8], received: Callable[[], bool]) -> bool:
        """Stay there, and publish until it was received."""
        depth = np.full(picture.shape[:2], 900, np.uint16)

        def again() -> bool:
            self.stamp += 0.1
            self.info.publish(
                CameraInfo(
                    header=header(self.stamp, "camera_color_optical_frame"), width=LENS.pinhole.width,
                    height=LENS.pinhole.height, k=LENS.matrix.reshape(-1), distortion_model="plumb_bob",
                )
            )  # fmt: skip
            self.tool.publish(pose_stamped(tool, self.stamp))
            self.depth.publish(image(depth, "16UC1", self.stamp))
            self.color.publish(image(picture, "bgr8", self.stamp))
            return received()

        return self.until(again)

    def close(self) -> None:
        self.executor.shutdown()
        self.node.destroy_node()
        self.taking.destroy_node()
        rclpy.shutdown(context=self.context)


@pytest.fixture
def drivers(ros_domain: int, tmp_path: Path) -> Iterator[Drivers]:
    taking = PictureTaking(tmp_path / "calib", BOARD, BoardMounting.HAND, 3)
    made = Drivers(ros_domain, taking)
    yield made
    made.close()


def test_a_picture_is_taken_where_the_hand_rests_anew_and_the_board_is_seen(drivers: Drivers, tmp_path: Path) -> None:
    down = Rotation.from_euler("x", np.pi)
    y = transform(np.eye(3), (-0.12, -0.1, 0.0))
    tools = [
        transform((Rotation.from_rotvec(turn) * down).as_matrix(), (0.58 + 0.02 * k, 0.0, 0.35))
        for k, turn in enumerate(([0.0, 0.2, 0.0], [0.25, 0.0, 0.0], [-0.1, -0.2, 0.3]))
    ]
    blank = np.full((480, 640, 3), 120, np.uint8)
    assert drivers.rest(tools[0], blank, lambda: any("the board is not seen" in s for s in drivers.said)), drivers.said
    assert not (tmp_path / "calib").exists()
    for k, tool in enumerate(tools):
        picture = pictured(tool @ y)
        assert drivers.rest(tool, picture, lambda k=k: drivers.taking.collector.count > k), drivers.said  # type: ignore[misc]
        if k == 0:  # it goes on resting there: one picture is enough
            drivers.rest(tool, picture, lambda until=drivers.stamp + 3.0: drivers.stamp > until)  # type: ignore[misc]
            assert drivers.taking.collector.count == 1
    assert drivers.taking.collector.done
    held = read_pictures(tmp_path / "calib")
    assert held.base_frame == "base" and held.camera_frame == "camera_color_optical_frame"
    assert held.board == BOARD and held.lens is not None and held.lens.pinhole == LENS.pinhole
    for picture, tool in zip(held.pictures, tools, strict=True):
        assert np.abs(picture.tool - tool).max() < 1e-4
    assert len(list((tmp_path / "calib").glob("*_depth.png"))) == 3


@pytest.mark.parametrize(
    ("encoding", "pixel", "rgb"),
    [("rgb8", (1, 2, 3), (1, 2, 3)), ("bgr8", (3, 2, 1), (1, 2, 3)), ("bgra8", (3, 2, 1, 9), (1, 2, 3)),
     ("rgba8", (1, 2, 3, 9), (1, 2, 3)), ("mono8", (7,), (7, 7, 7))],
)  # fmt: skip
def test_a_picture_is_the_same_whatever_its_encoding(
    encoding: str, pixel: tuple[int, ...], rgb: tuple[int, int, int]
) -> None:
    made = image(np.full((4, 6, len(pixel)), pixel, np.uint8), encoding, 1.0)
    assert (rgb_from_image(made) == rgb).all()
    made.encoding = "rgb16"
    with pytest.raises(ValueError, match="expected one of"):
        rgb_from_image(made)


def test_depth_is_metres_whatever_its_encoding() -> None:
    assert depth_from_image(image(np.full((2, 3), 1500, np.uint16), "16UC1", 1.0)) == pytest.approx(1.5)
    floats = np.full((2, 3), 1.5, np.float32).view(np.uint8).reshape(2, 12)
    made = image(floats, "32FC1", 1.0)
    made.width = 3
    assert depth_from_image(made) == pytest.approx(1.5)
