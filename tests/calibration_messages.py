"""A printed board before the camera, and what robot and camera say of it, as real messages."""

from __future__ import annotations

import array

import cv2
import numpy as np
from board_scene import BOARD, CAMERA, LENS
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from mbd_model.ros.conversions import header
from mbd_robot.calibration.transforms import Transforms, inverse
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import Image

WHITE = 235


def image(pixels: NDArray[np.uint8] | NDArray[np.uint16], encoding: str, stamp: float) -> Image:
    data = array.array("B")
    data.frombytes(np.ascontiguousarray(pixels).tobytes())
    height, width = pixels.shape[:2]
    return Image(
        header=header(stamp, "camera_color_optical_frame"), height=height, width=width, encoding=encoding,
        step=len(data) // height, data=data,
    )  # fmt: skip


def pictured(board2base: Transforms) -> NDArray[np.uint8]:
    """(H, W, 3) BGR of the board there, as a flat picture is warped by the camera."""
    per_square = 40
    flat = np.full((BOARD.rows * per_square + 80, BOARD.columns * per_square + 80), WHITE, np.uint8)
    flat[40:-40, 40:-40] = BOARD.drawn(per_square)
    pose = inverse(CAMERA) @ board2base
    outline = LENS.project(BOARD.outline @ pose[:3, :3].T + pose[:3, 3]).astype(np.float32)
    h, w = flat.shape
    corners = np.array([[40, 40], [w - 40, 40], [w - 40, h - 40], [40, h - 40]], np.float32) - 0.5
    warp = cv2.getPerspectiveTransform(corners, outline)
    size = (LENS.pinhole.width, LENS.pinhole.height)
    grey = cv2.warpPerspective(flat, warp, size, flags=cv2.INTER_AREA, borderValue=120)
    return np.asarray(cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR), dtype=np.uint8)


def pose_stamped(tool: Transforms, stamp: float) -> PoseStamped:
    x, y, z, w = Rotation.from_matrix(tool[:3, :3]).as_quat()
    place = Point(x=float(tool[0, 3]), y=float(tool[1, 3]), z=float(tool[2, 3]))
    return PoseStamped(
        header=header(stamp, "base"), pose=Pose(position=place, orientation=Quaternion(x=x, y=y, z=z, w=w))
    )  # fmt: skip
