"""A camera's driver in the cell: its topics, encodings and transports."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from mbd_model.ros.conversions import stamp_to_msg
from mbd_robot.images import HEADER
from mbd_robot.profiles.camera import CameraProfile, ImageTransport
from mbd_robot.profiles.robot import Reliability
from mbd_robot.ros.camera_node import image_msg
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Header

from mbd_cell.physics.camera import Frame
from mbd_cell.ros import conversions as convert

DEPTH_MAX, QUANTIZATION = 10.0, 100.0  # of compressed_depth_image_transport
CHANNELS = {"rgb8": (0, 1, 2), "bgr8": (2, 1, 0), "rgba8": (0, 1, 2, 3), "bgra8": (2, 1, 0, 3)}


class StandInCamera:
    """What ``OwnCamera`` is, in a driver's words."""

    def __init__(self, node: Node, profile: CameraProfile) -> None:
        self._profile = profile
        best_effort = profile.reliability is Reliability.BEST_EFFORT
        quality = qos_profile_sensor_data if best_effort else QoSProfile(depth=1)
        self._color = _publisher(node, profile.color.topic, profile.color.transport, quality)
        self._depth = _publisher(node, profile.depth.topic, profile.depth.transport, quality)
        self._info = node.create_publisher(CameraInfo, profile.camera_info, quality)

    def watched(self) -> bool:
        """Whether anybody listens."""
        return any(p.get_subscription_count() for p in (self._color, self._depth, self._info))

    def publish(self, frame: Frame, stamp: int) -> None:
        """One image of that time [ns]."""
        header = Header(stamp=stamp_to_msg(stamp), frame_id=self._profile.frame)
        info = convert.camera_info_to_msg(stamp)
        info.header = header
        self._info.publish(info)
        encoding = self._profile.color.encoding
        if self._profile.color.transport is ImageTransport.RAW:
            self._color.publish(image_msg(in_encoding(frame.color, encoding), encoding, header))
        else:
            self._color.publish(jpeg(frame.color, header))
        units = self._profile.depth.encoding
        depth: NDArray[Any] = frame.depth_mm
        if units == "32FC1":
            # Metres, and NaN where nothing returned.
            depth = np.where(frame.depth > 0, frame.depth, np.float32(np.nan)).astype(np.float32)
        if self._profile.depth.transport is ImageTransport.RAW:
            self._depth.publish(image_msg(depth, units, header))
        else:
            self._depth.publish(compressed_depth(depth, units, header))


def _publisher(node: Node, topic: str, transport: ImageTransport, quality: QoSProfile) -> Any:
    if transport is ImageTransport.RAW:
        return node.create_publisher(Image, topic, quality)
    return node.create_publisher(CompressedImage, f"{topic}/{transport.value}", quality)


def in_encoding(rgb: NDArray[np.uint8], encoding: str) -> NDArray[np.uint8]:
    """(H, W, 3) RGB as (H, W, C) of an encoding of CHANNELS."""
    opaque = np.concatenate((rgb, np.full((*rgb.shape[:2], 1), 255, np.uint8)), axis=-1)
    return np.ascontiguousarray(opaque[..., list(CHANNELS[encoding])])


def jpeg(rgb: NDArray[np.uint8], header: Header) -> CompressedImage:
    """Colour as compressed_image_transport sends it."""
    _, data = cv2.imencode(".jpg", np.ascontiguousarray(rgb[..., ::-1]), [cv2.IMWRITE_JPEG_QUALITY, 95])
    return CompressedImage(header=header, format="rgb8; jpeg compressed bgr8", data=data.tobytes())


def compressed_depth(depth: NDArray[Any], encoding: str, header: Header) -> CompressedImage:
    """Depth as compressed_depth_image_transport sends it: a PNG behind 12 bytes."""
    a, b = 0.0, 0.0
    pixels = depth
    if encoding == "32FC1":
        a = QUANTIZATION * (QUANTIZATION + 1.0)
        b = 1.0 - a / DEPTH_MAX
        seen = np.nan_to_num(depth, nan=0.0)
        inverse = np.where(seen > 0, a / np.maximum(seen, 1e-6) + b, 0.0)
        pixels = np.clip(inverse, 0, 65535).astype(np.uint16)
    _, data = cv2.imencode(".png", pixels)
    return CompressedImage(
        header=header, format=f"{encoding}; compressedDepth png", data=HEADER.pack(0, a, b) + data.tobytes()
    )
