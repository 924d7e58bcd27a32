"""Colours and optics as drivers publish them."""

from __future__ import annotations

import array

import cv2
import numpy as np
import pytest
from mbd_model.camera.intrinsics import Intrinsics
from mbd_perception.frames.frame import FrameError
from mbd_perception.ros.camera_conversions import (
    color_from_msg,
    depth_from_msg,
    intrinsics_from_msg,
    turned_with_picture,
)
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
        ("8UC3", PICTURE[..., ::-1]),
        ("8UC4", np.dstack([PICTURE[..., ::-1], np.full(PICTURE.shape[:2], 9, np.uint8)])),
        ("rgb16", np.stack([np.full_like(PICTURE, 7), PICTURE], axis=-1).reshape(*PICTURE.shape[:2], 6)),
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


@pytest.mark.parametrize("encoding", ["mono8", "8UC1", "mono16"])
def test_grey(encoding: str) -> None:
    """A grey picture has three equal channels; of 16 bits the upper eight count."""
    grey = PICTURE[..., :1]
    low = [] if encoding != "mono16" else [np.full_like(grey, 200)]
    made = color_from_msg(message(encoding, np.concatenate([*low, grey], axis=-1)))
    np.testing.assert_array_equal(made, np.repeat(grey, 3, axis=-1))


@pytest.mark.parametrize("encoding", ["bayer_rggb8", "bayer_bggr8", "bayer_gbrg8", "bayer_grbg8"])
def test_bayer(encoding: str) -> None:
    """A plain red surface is red, whichever colour the sensor starts with."""
    color = {"r": 220, "g": 40, "b": 20}
    two_by_two = np.array([color[c] for c in encoding[6:10]], np.uint8).reshape(2, 2)
    made = color_from_msg(message(encoding, np.tile(two_by_two, (4, 5))[..., None]))
    np.testing.assert_array_equal(made[2:-2, 2:-2], np.broadcast_to(np.uint8([220, 40, 20]), (4, 6, 3)))


def test_padded_rows() -> None:
    """Rows may be longer than their pixels."""
    padded = np.concatenate([PICTURE.reshape(4, 18), np.full((4, 5), 77, np.uint8)], axis=1)
    image = message("rgb8", padded[..., None])
    image.width, image.step = 6, 23
    np.testing.assert_array_equal(color_from_msg(image), PICTURE)


@pytest.mark.parametrize("bigendian", [0, 1])
def test_byte_order(bigendian: int) -> None:
    """Depth of either byte order is the same depth."""
    depth = np.array([[500, 1000], [2000, 65535]], dtype=">u2" if bigendian else "<u2")
    image = message("16UC1", depth.view(np.uint8).reshape(2, 2, 2))
    image.is_bigendian = bigendian
    np.testing.assert_array_equal(depth_from_msg(image), [[500, 1000], [2000, 65535]])


def test_turned_with_picture() -> None:
    """A picture turned by a quarter, whose camera_info was not, has its focal lengths swapped."""
    camera = Intrinsics(600.0, 610.0, 321.0, 238.0, width=640, height=480)
    turned = turned_with_picture(camera, 640, 480)
    assert (turned.fx, turned.fy, turned.width, turned.height) == (610.0, 600.0, 480, 640)
    assert (turned.cx, turned.cy) == pytest.approx((239.5, 319.5), abs=2.0)
    assert turned_with_picture(camera, 480, 640) is camera
    with pytest.raises(FrameError, match="publish camera_info turned"):
        turned_with_picture(Intrinsics(600.0, 610.0, 250.0, 238.0, width=640, height=480), 640, 480)


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


def test_binned_region() -> None:
    """A region of the sensor, binned: the ray of its first pixel is that of the middle of the sensor's pixels."""
    region = RegionOfInterest(x_offset=100, y_offset=40, width=320, height=240)
    camera = intrinsics_from_msg(info(binning_x=2, binning_y=2, roi=region))
    full = intrinsics_from_msg(info())
    assert (camera.width, camera.height) == (160, 120)
    assert (0 - camera.cx) / camera.fx == pytest.approx((100.5 - full.cx) / full.fx)
    assert (0 - camera.cy) / camera.fy == pytest.approx((40.5 - full.cy) / full.fy)


def test_region() -> None:
    """The ray of a pixel of a region is that of the same pixel of the sensor."""
    camera = intrinsics_from_msg(info(roi=RegionOfInterest(x_offset=100, y_offset=40, width=320, height=240)))
    assert (camera.width, camera.height, camera.cx, camera.cy) == (320, 240, 220.0, 200.0)
