"""From what a camera's driver publishes to frames: images of any encoding, compressed or not, optics, clouds."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from mbd_model.camera.intrinsics import Intrinsics
from mbd_model.ros.conversions import time_from_msg
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, PointCloud2

from mbd_perception.frames.clouds import CloudBytes, CloudField, frame_from_cloud
from mbd_perception.frames.compressed_images import decode_color, decode_depth
from mbd_perception.frames.frame import FrameError, RgbdFrame, make_frame

# Channels of an encoding, which of them are red, green and blue, and bytes of each.
COLOR_ENCODINGS = {
    "rgb8": (3, (0, 1, 2), 1),
    "bgr8": (3, (2, 1, 0), 1),
    "rgba8": (4, (0, 1, 2), 1),
    "bgra8": (4, (2, 1, 0), 1),
    "mono8": (1, (0, 0, 0), 1),
    "rgb16": (3, (0, 1, 2), 2),
    "bgr16": (3, (2, 1, 0), 2),
    "mono16": (1, (0, 0, 0), 2),
    # OpenCV's names, which state no order: its own is blue first.
    "8UC1": (1, (0, 0, 0), 1),
    "8UC3": (3, (2, 1, 0), 1),
    "8UC4": (4, (2, 1, 0), 1),
}
# Two pixels in four bytes: their brightnesses and the two colour differences they share.
YUV_ENCODINGS = {
    "uyvy": cv2.COLOR_YUV2RGB_UYVY,
    "yuv422": cv2.COLOR_YUV2RGB_UYVY,
    "yuyv": cv2.COLOR_YUV2RGB_YUY2,
    "yuv422_yuy2": cv2.COLOR_YUV2RGB_YUY2,
}
# One colour a pixel. ROS names the first two by two pixels; OpenCV names the four that start one further.
BAYER_ENCODINGS = {
    "bayer_rggb8": cv2.COLOR_BayerBG2RGB,
    "bayer_bggr8": cv2.COLOR_BayerRG2RGB,
    "bayer_gbrg8": cv2.COLOR_BayerGR2RGB,
    "bayer_grbg8": cv2.COLOR_BayerGB2RGB,
}
DEPTH_ENCODINGS = {"16UC1": "u2", "mono16": "u2", "32FC1": "f4"}
# The middle of a picture that was turned is known up to this share of its width, whichever way it was turned.
OFF_CENTER = 0.03


def pixels(image: Image, channels: int, dtype: np.dtype[Any]) -> NDArray[Any]:
    """(height, width, channels) view of an image; raises FrameError when its data is too short."""
    needed = image.width * channels * dtype.itemsize
    if image.height < 1 or image.width < 1:
        raise FrameError(f"{image.encoding} image is {image.width}x{image.height} pixels: check the camera")
    if image.step < needed or len(image.data) < (image.height - 1) * image.step + needed:
        raise FrameError(
            f"{image.encoding} image of {image.width}x{image.height} is cut off: step {image.step}, {len(image.data)} "
            f"bytes, needs {needed} a row"
        )
    strides = (image.step, channels * dtype.itemsize, dtype.itemsize)
    return np.ndarray((image.height, image.width, channels), dtype, memoryview(image.data), 0, strides)


def color_from_msg(image: Image | CompressedImage) -> NDArray[np.uint8]:
    """(height, width, 3) uint8 RGB; raises FrameError for an encoding that is no colour."""
    if isinstance(image, CompressedImage):
        return decode_color(memoryview(image.data), image.format)
    if image.encoding in YUV_ENCODINGS:
        if image.width % 2:
            raise FrameError(f"{image.encoding} image is {image.width} pixels wide: pairs of pixels share their colour")
        packed = np.ascontiguousarray(pixels(image, 2, np.dtype("u1")))
        return np.asarray(cv2.cvtColor(packed, YUV_ENCODINGS[image.encoding]), dtype=np.uint8)
    if image.encoding in BAYER_ENCODINGS:
        if image.width < 2 or image.height < 2:
            raise FrameError(f"{image.encoding} image of {image.width}x{image.height} pixels lacks a colour")
        mosaic = np.ascontiguousarray(pixels(image, 1, np.dtype("u1")))
        return np.asarray(cv2.cvtColor(mosaic, BAYER_ENCODINGS[image.encoding]), dtype=np.uint8)
    if image.encoding not in COLOR_ENCODINGS:
        known = ", ".join((*COLOR_ENCODINGS, *YUV_ENCODINGS, *BAYER_ENCODINGS))
        raise FrameError(f"colour encoding '{image.encoding}' is not supported; expected one of {known}")
    channels, order, size = COLOR_ENCODINGS[image.encoding]
    kind = np.dtype(f"u{size}").newbyteorder(">" if image.is_bigendian else "<")
    values = pixels(image, channels, kind)
    if size == 2:
        values = (values >> 8).astype(np.uint8)
    return np.ascontiguousarray(values if order == (0, 1, 2) and channels == 3 else values[..., list(order)])


def depth_from_msg(image: Image | CompressedImage) -> NDArray[np.uint16] | NDArray[np.float32]:
    """(height, width) depth, uint16 mm or float32 m; raises FrameError for another encoding."""
    if isinstance(image, CompressedImage):
        return decode_depth(memoryview(image.data), image.format)
    if image.encoding not in DEPTH_ENCODINGS:
        raise FrameError(
            f"depth encoding '{image.encoding}' is not supported; expected 16UC1 (millimetres) or 32FC1 (metres)"
        )
    dtype = np.dtype(DEPTH_ENCODINGS[image.encoding]).newbyteorder(">" if image.is_bigendian else "<")
    values = pixels(image, 1, dtype)[..., 0]
    return values.astype(dtype.newbyteorder("="))


def picture_size(info: CameraInfo) -> tuple[int, int]:
    """(width, height) [px] of the pictures that come with a camera_info: of its region, binned."""
    x, y = max(int(info.binning_x), 1), max(int(info.binning_y), 1)
    return (int(info.roi.width) or int(info.width)) // x, (int(info.roi.height) or int(info.height)) // y


def intrinsics_from_msg(info: CameraInfo) -> Intrinsics:
    """The camera of the pictures that come with a camera_info; raises CameraError when it was never calibrated.

    Its numbers are those of the complete sensor: a driver that publishes a region of it, or bins pixels, says so.
    """
    x, y = max(int(info.binning_x), 1), max(int(info.binning_y), 1)
    roi = info.roi
    width, height = picture_size(info)
    # Pixel centres are at integers: of n binned pixels the centre is (n - 1) / 2 further.
    cx = (info.k[2] - roi.x_offset - 0.5 * (x - 1)) / x
    cy = (info.k[5] - roi.y_offset - 0.5 * (y - 1)) / y
    return Intrinsics(fx=info.k[0] / x, fy=info.k[4] / y, cx=cx, cy=cy, width=width, height=height)


def turned_with_picture(camera: Intrinsics, height: int, width: int) -> Intrinsics:
    """The camera of a picture of ``height`` x ``width`` px, which somebody may have turned by a quarter without it.

    Which way it was turned nobody says; it matters only where the principal point lies off the middle.

    Raises:
        FrameError: it was turned, and does.
    """
    if (height, width) == (camera.height, camera.width) or (height, width) != (camera.width, camera.height):
        return camera
    off = abs(camera.cx - 0.5 * (camera.width - 1)), abs(camera.cy - 0.5 * (camera.height - 1))
    if max(off) > OFF_CENTER * max(height, width):
        raise FrameError(
            f"camera_info states {camera.width}x{camera.height} but the images are {width}x{height}: they were turned "
            "by a quarter and camera_info was not, and its principal point is too far off the middle to tell which "
            "way; publish camera_info turned, too"
        )
    return Intrinsics(
        camera.fy, camera.fx, 0.5 * (width - 1), 0.5 * (height - 1), width=camera.height, height=camera.width
    )


def frame_from_images(color: Image | CompressedImage, depth: Image | CompressedImage, info: CameraInfo) -> RgbdFrame:
    """A frame from colour, depth and camera_info; raises FrameError, or CameraError for optics that are none."""
    distances = depth_from_msg(depth)
    camera = turned_with_picture(intrinsics_from_msg(info), *distances.shape)
    return make_frame(color_from_msg(color), distances, camera, time_from_msg(depth.header.stamp))


def frame_from_cloud_msg(cloud: PointCloud2) -> RgbdFrame:
    """A frame from an organized cloud; raises FrameError."""
    return frame_from_cloud(
        CloudBytes(
            width=cloud.width,
            height=cloud.height,
            fields=[CloudField(f.name, f.offset, f.datatype) for f in cloud.fields],
            point_step=cloud.point_step,
            row_step=cloud.row_step,
            data=memoryview(cloud.data),
            bigendian=cloud.is_bigendian,
        ),
        time_from_msg(cloud.header.stamp),
    )
