"""Between sensor_msgs and frames, and from scenes to visualization and diagnostic messages."""

from __future__ import annotations

import array
import colorsys
from typing import Any

import cv2
import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from geometry_msgs.msg import Point, Vector3
from mbd_model.camera.intrinsics import Intrinsics
from mbd_model.objects import Scene
from mbd_model.ros.conversions import header, time_from_msg
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo, Image, PointCloud2
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from mbd_perception.frames.clouds import CloudBytes, CloudField, frame_from_cloud
from mbd_perception.frames.frame import FrameError, RgbdFrame, make_frame

# Channels of an encoding, and which of them are red, green and blue.
COLOR_ENCODINGS = {
    "rgb8": (3, (0, 1, 2)),
    "bgr8": (3, (2, 1, 0)),
    "rgba8": (4, (0, 1, 2)),
    "bgra8": (4, (2, 1, 0)),
    "mono8": (1, (0, 0, 0)),
}
# Two pixels in four bytes: their brightnesses and the two colour differences they share.
YUV_ENCODINGS = {
    "uyvy": cv2.COLOR_YUV2RGB_UYVY,
    "yuv422": cv2.COLOR_YUV2RGB_UYVY,
    "yuyv": cv2.COLOR_YUV2RGB_YUY2,
    "yuv422_yuy2": cv2.COLOR_YUV2RGB_YUY2,
}
DEPTH_ENCODINGS = {"16UC1": "u2", "mono16": "u2", "32FC1": "f4"}


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


def color_from_msg(image: Image) -> NDArray[np.uint8]:
    """(height, width, 3) uint8 RGB; raises FrameError for an encoding that is no colour."""
    if image.encoding in YUV_ENCODINGS:
        if image.width % 2:
            raise FrameError(f"{image.encoding} image is {image.width} pixels wide: pairs of pixels share their colour")
        packed = np.ascontiguousarray(pixels(image, 2, np.dtype("u1")))
        return np.asarray(cv2.cvtColor(packed, YUV_ENCODINGS[image.encoding]), dtype=np.uint8)
    if image.encoding not in COLOR_ENCODINGS:
        known = ", ".join((*COLOR_ENCODINGS, *YUV_ENCODINGS))
        raise FrameError(f"colour encoding '{image.encoding}' is not supported; expected one of {known}")
    channels, order = COLOR_ENCODINGS[image.encoding]
    values = pixels(image, channels, np.dtype("u1"))
    return np.ascontiguousarray(values if order == (0, 1, 2) and channels == 3 else values[..., list(order)])


def depth_from_msg(image: Image) -> NDArray[np.uint16] | NDArray[np.float32]:
    """(height, width) depth, uint16 mm or float32 m; raises FrameError for another encoding."""
    if image.encoding not in DEPTH_ENCODINGS:
        raise FrameError(
            f"depth encoding '{image.encoding}' is not supported; expected 16UC1 (millimetres) or 32FC1 (metres)"
        )
    dtype = np.dtype(DEPTH_ENCODINGS[image.encoding]).newbyteorder(">" if image.is_bigendian else "<")
    values = pixels(image, 1, dtype)[..., 0]
    return values.astype(dtype.newbyteorder("="))


def intrinsics_from_msg(info: CameraInfo) -> Intrinsics:
    """The camera of the pictures that come with a camera_info; raises CameraError when it was never calibrated.

    Its numbers are those of the complete sensor: a driver that publishes a region of it, or bins pixels, says so.
    """
    x, y = max(int(info.binning_x), 1), max(int(info.binning_y), 1)
    roi = info.roi
    width, height = int(roi.width) or int(info.width), int(roi.height) or int(info.height)
    # Pixel centres are at integers: of n binned pixels the centre is (n - 1) / 2 further.
    cx = (info.k[2] - roi.x_offset - 0.5 * (x - 1)) / x
    cy = (info.k[5] - roi.y_offset - 0.5 * (y - 1)) / y
    return Intrinsics(fx=info.k[0] / x, fy=info.k[4] / y, cx=cx, cy=cy, width=width // x, height=height // y)


def frame_from_images(color: Image, depth: Image, info: CameraInfo) -> RgbdFrame:
    """A frame from colour, depth and camera_info; raises FrameError."""
    return make_frame(
        color_from_msg(color), depth_from_msg(depth), intrinsics_from_msg(info), time_from_msg(depth.header.stamp)
    )


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


def scene_markers(scene: Scene, table: tuple[float, float, float, float]) -> MarkerArray:
    """A box in the object's colour and a label above it for every object; replaces what was shown before.

    ``table`` is (a, b, c, d) of the plane they stand on [m, frame of the scene].
    """
    a, b, c, d = table
    markers = [Marker(header=header(scene.stamp, scene.frame_id), action=Marker.DELETEALL)]
    for number, obj in enumerate(scene.objects):
        width, depth, height = obj.size
        x, y, _ = obj.box_center or obj.centroid
        foot = -(a * x + b * y + d) / c
        hue = 0.0 if obj.hue is None else obj.hue / 360.0
        red, green, blue = colorsys.hsv_to_rgb(hue, 0.0 if obj.hue is None else 0.9, 0.9)
        box = Marker(
            header=header(scene.stamp, scene.frame_id),
            ns=f"{scene.role}_boxes",
            id=number,
            type=Marker.CUBE,
            scale=Vector3(x=depth, y=width, z=height),
            color=ColorRGBA(r=red, g=green, b=blue, a=0.5),
        )
        box.pose.position = Point(x=x, y=y, z=foot + height / 2)
        box.pose.orientation.z = float(np.sin(obj.yaw / 2))
        box.pose.orientation.w = float(np.cos(obj.yaw / 2))
        label = Marker(
            header=header(scene.stamp, scene.frame_id),
            ns=f"{scene.role}_labels",
            id=number,
            type=Marker.TEXT_VIEW_FACING,
            scale=Vector3(x=0.0, y=0.0, z=0.03),
            color=ColorRGBA(r=1.0, g=1.0, b=1.0, a=1.0),
            text=f"{obj.object_id} {obj.color_name} {obj.object_class}",
        )
        label.pose.position = Point(x=x, y=y, z=foot + height + 0.04)
        markers += [box, label]
    return MarkerArray(markers=markers)


def color_to_msg(picture: NDArray[np.uint8], stamp: float, frame_id: str) -> Image:
    """(height, width, 3) uint8 RGB as an rgb8 image."""
    height, width = picture.shape[:2]
    data = array.array("B")
    data.frombytes(np.ascontiguousarray(picture).data.cast("B"))
    return Image(header=header(stamp, frame_id), height=height, width=width, encoding="rgb8", step=3 * width, data=data)


def status(name: str, problem: str, values: dict[str, str]) -> DiagnosticStatus:
    """One diagnostic status: OK when ``problem`` is empty, else a warning that states it."""
    return DiagnosticStatus(
        level=DiagnosticStatus.WARN if problem else DiagnosticStatus.OK,
        name=name,
        message=problem or "working",
        values=[KeyValue(key=key, value=value) for key, value in values.items()],
    )
