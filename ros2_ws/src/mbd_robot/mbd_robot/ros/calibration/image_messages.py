"""Images and camera_info of the suite's camera topics, as a calibration takes them."""

from __future__ import annotations

import cv2
import numpy as np
from geometry_msgs.msg import Pose
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo, Image

from mbd_robot.calibration.errors import CalibrationError
from mbd_robot.calibration.lens import CalibratedLens, lens_of
from mbd_robot.calibration.transforms import Transforms, from_quaternion

# Channels of an encoding, and what OpenCV makes RGB of it with; None: nothing to do.
COLORS: dict[str, tuple[int, int | None]] = {
    "rgb8": (3, None),
    "bgr8": (3, cv2.COLOR_BGR2RGB),
    "8UC3": (3, cv2.COLOR_BGR2RGB),
    "rgba8": (4, cv2.COLOR_RGBA2RGB),
    "bgra8": (4, cv2.COLOR_BGRA2RGB),
    "8UC4": (4, cv2.COLOR_BGRA2RGB),
    "mono8": (1, cv2.COLOR_GRAY2RGB),
    "8UC1": (1, cv2.COLOR_GRAY2RGB),
    "yuv422": (2, cv2.COLOR_YUV2RGB_UYVY),
    "uyvy": (2, cv2.COLOR_YUV2RGB_UYVY),
    "yuv422_yuy2": (2, cv2.COLOR_YUV2RGB_YUY2),
    "yuyv": (2, cv2.COLOR_YUV2RGB_YUY2),
}


def rgb_from_image(msg: Image) -> NDArray[np.uint8]:
    """(H, W, 3) uint8 RGB; raises CalibrationError for an encoding that is not read, or too few bytes."""
    if msg.encoding not in COLORS:
        raise CalibrationError(f"images of encoding '{msg.encoding}'; expected one of {', '.join(COLORS)}")
    channels, change = COLORS[msg.encoding]
    rows = _rows(msg, channels)
    picture = rows.reshape(msg.height, msg.width, channels)
    if channels == 1:
        picture = picture[..., 0]
    return np.ascontiguousarray(picture if change is None else cv2.cvtColor(picture, change), dtype=np.uint8)


def depth_from_image(msg: Image) -> NDArray[np.float32]:
    """(H, W) [m], NaN or 0 where nothing returned; raises CalibrationError for another encoding."""
    if msg.encoding in ("16UC1", "mono16"):
        kind = np.dtype(np.uint16).newbyteorder(">" if msg.is_bigendian else "<")
        return (_rows(msg, 2).view(kind).astype(np.float32) / np.float32(1000.0)).reshape(msg.height, msg.width)
    if msg.encoding == "32FC1":
        real = np.dtype(np.float32).newbyteorder(">" if msg.is_bigendian else "<")
        return _rows(msg, 4).view(real).astype(np.float32).reshape(msg.height, msg.width)
    raise CalibrationError(f"depth images of encoding '{msg.encoding}'; expected 16UC1 or 32FC1")


def lens_from_info(msg: CameraInfo) -> CalibratedLens:
    """The lens of a camera_info; raises CalibrationError when it states none."""
    return lens_of([float(v) for v in msg.k], (msg.width, msg.height), list(msg.d), msg.distortion_model, "camera_info")


def transform_from_pose(msg: Pose) -> Transforms:
    """(4, 4) of a pose; raises CalibrationError for a quaternion that is none."""
    p, q = msg.position, msg.orientation
    quaternion = np.array((q.x, q.y, q.z, q.w))
    if not abs(float(np.linalg.norm(quaternion)) - 1.0) < 0.05:
        raise CalibrationError(f"a tool pose with quaternion {quaternion.tolist()}; expected one of length 1")
    return from_quaternion((p.x, p.y, p.z), quaternion)


def _rows(msg: Image, per_pixel: int) -> NDArray[np.uint8]:
    """(H, W * bytes of a pixel) uint8, without what pads a row."""
    wanted = msg.width * per_pixel
    if msg.step < wanted or len(msg.data) < msg.step * msg.height:
        raise CalibrationError(f"an image of {msg.width} x {msg.height} {msg.encoding} has too few bytes")
    data = np.frombuffer(msg.data, np.uint8)[: msg.step * msg.height]
    return np.ascontiguousarray(data.reshape(msg.height, msg.step)[:, :wanted])
