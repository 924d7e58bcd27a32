"""Colours and optics as drivers publish them."""

from __future__ import annotations

import array

import cv2
import numpy as np
import pytest
from mbd_perception.frames.frame import FrameError
from mbd_perception.ros.conversions import color_from_msg, intrinsics_from_msg
from sensor_msgs.msg import CameraInfo, Image, RegionOfInterest

# Equal in pairs of columns, so that halving the resolution of colour loses nothing.
PICTURE = np.repeat(np.random.default_rng(2).integers(40, 216, (4, 3, 3)), 2, axis=1).astype(np.uint8)


def message(encoding: str, data: np.ndarray) -> Image:
    """An image message of (height, width, channels) bytes."""
    height, width, channels = data.shape
    raw = array.array("B", np.ascontiguousarray(data).tobytes())
    return Image(height=height, width=width, encoding=encoding, step=channels * width, data=raw)


@pytest.mark.parametrize(
    ("encoding", "data"),
    [
        ("rgb8", PICTURE),
        ("bgr8", PICTURE[..., ::-1]),
        ("rgba8", np.dstack([PICTURE, np.full(PICTURE.shape[:2], 9, np.uint8)])),
        ("bgra8", np.dstack([PICTURE[..., ::-1], np.full(PICTURE.shape[:2], 9, np.uint8)])),
    ],
)
def test_orders(encoding: str, data: np.ndarray) -> None:
    """Whatever the order of the channels, the same picture comes out."""
    np.testing.assert_array_equal(color_from_msg(message(encoding, data)), PICTURE)


@pytest.mark.parametrize(
    ("encoding", "code"),
    [("yuyv", cv2.COLOR_RGB2YUV_YUY2), ("yuv422_yuy2", cv2.COLOR_RGB2YUV_YUY2), ("uyvy", cv2.COLOR_RGB2YUV_UYVY)],
)
def test_yuv(encoding: str, code: int) -> None:
    """Two pixels in four bytes: the picture comes back up to rounding."""
    packed = cv2.cvtColor(PICTURE, code)
    np.testing.assert_allclose(color_from_msg(message(encoding, packed)).astype(int), PICTURE.astype(int), atol=6)


def test_odd_yuv() -> None:
    """Half a pair of pixels is refused."""
    with pytest.raises(FrameError, match="pairs of pixels"):
        color_from_msg(message("yuyv", np.zeros((2, 3, 2), np.uint8)))


def info(**more: object) -> CameraInfo:
    """The optics of a 640x480 sensor."""
    k = [500.0, 0.0, 320.0, 0.0, 510.0, 240.0, 0.0, 0.0, 1.0]
    return CameraInfo(width=640, height=480, k=k, **more)


@pytest.mark.parametrize("binning", [1, 2, 4])
def test_binned(binning: int) -> None:
    """The ray of a binned pixel is that of the middle of the pixels it was made of."""
    camera = intrinsics_from_msg(info(binning_x=binning, binning_y=binning))
    assert (camera.width, camera.height) == (640 // binning, 480 // binning)
    full = intrinsics_from_msg(info())
    middle = 10 * binning + 0.5 * (binning - 1)
    assert (10 - camera.cx) / camera.fx == pytest.approx((middle - full.cx) / full.fx)
    assert (10 - camera.cy) / camera.fy == pytest.approx((middle - full.cy) / full.fy)


def test_region() -> None:
    """The ray of a pixel of a region is that of the same pixel of the sensor."""
    camera = intrinsics_from_msg(info(roi=RegionOfInterest(x_offset=100, y_offset=40, width=320, height=240)))
    assert (camera.width, camera.height, camera.cx, camera.cy) == (320, 240, 220.0, 200.0)
