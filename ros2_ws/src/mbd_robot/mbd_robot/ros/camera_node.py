"""The camera node: any RGB-D driver's topics, transports and encodings, as the suite's three camera topics."""

from __future__ import annotations

import array
import math
from typing import Any

import numpy as np
from mbd_model.errors import MbdError
from mbd_model.ros.conversions import time_from_msg
from mbd_model.ros.parameters import TableNode
from mbd_model.ros.qos import IMAGES, SENSOR
from mbd_model.ros.run_node import run_node
from numpy.typing import NDArray
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Header

from mbd_robot.images import ImageError, decode_color, decode_depth
from mbd_robot.parameters import CAMERA
from mbd_robot.profiles.camera import COLOR, DEPTH, INFO, ColorStream, DepthStream, ImageTransport
from mbd_robot.profiles.find import camera_profile
from mbd_robot.profiles.robot import Reliability


class CameraNode(TableNode):
    """Publishes camera/color/image_raw, camera/depth/image_raw and camera/color/camera_info of the driver's images."""

    def __init__(self, **options: Any) -> None:
        super().__init__(CAMERA, **options)
        self.profile = camera_profile(self.values["camera"])
        if self.profile.names_are_the_suites:
            raise MbdError(f"{self.profile.title} publishes {COLOR}, {DEPTH} and {INFO} itself: leave this node out")
        self._last = {COLOR: -math.inf, DEPTH: -math.inf}
        reliable = self.profile.reliability is Reliability.RELIABLE
        quality = QoSProfile(depth=2, reliability=ReliabilityPolicy.RELIABLE) if reliable else SENSOR
        self._out = {name: self.create_publisher(Image, name, IMAGES) for name in (COLOR, DEPTH)}
        self._info = self.create_publisher(CameraInfo, INFO, SENSOR)
        self._listen(self.profile.color, COLOR, quality)
        self._listen(self.profile.depth, DEPTH, quality)
        self.create_subscription(CameraInfo, self.profile.camera_info, self._info.publish, quality)
        self.get_logger().info(f"{self.profile.title}; {self.profile.tested}")

    def _listen(self, stream: ColorStream | DepthStream, name: str, quality: QoSProfile) -> None:
        if stream.transport is ImageTransport.RAW:
            self.create_subscription(Image, stream.topic, lambda msg: self._pass_on(name, msg), quality)
            return
        topic = f"{stream.topic}/{stream.transport.value}"
        self.create_subscription(CompressedImage, topic, lambda msg: self._decode(name, msg, stream), quality)

    def _due(self, name: str, header: Header) -> bool:
        """Whether a frame of this moment is passed on: colour and depth of one moment alike."""
        stamp = time_from_msg(header.stamp)
        slot = math.floor(stamp * self.values["rate"] + 1e-6)
        if slot == self._last[name]:
            return False
        self._last[name] = slot
        return True

    def _pass_on(self, name: str, msg: Image) -> None:
        if self._due(name, msg.header):
            self._out[name].publish(msg)

    def _decode(self, name: str, msg: CompressedImage, stream: ColorStream | DepthStream) -> None:
        if not self._due(name, msg.header):
            return
        try:
            if isinstance(stream, ColorStream):
                image = image_msg(decode_color(bytes(msg.data)), "rgb8", msg.header)
            else:
                image = image_msg(decode_depth(bytes(msg.data), stream.encoding), stream.encoding, msg.header)
        except ImageError as error:
            self.get_logger().error(f"{stream.topic}: {error}", throttle_duration_sec=5.0)
            return
        self._out[name].publish(image)


def image_msg(pixels: NDArray[Any], encoding: str, header: Header) -> Image:
    """An image of pixels (H, W) or (H, W, C)."""
    data = array.array("B")
    data.frombytes(np.ascontiguousarray(pixels).data.cast("B"))
    height, width = pixels.shape[:2]
    return Image(
        header=header, height=height, width=width, encoding=encoding, step=len(data) // height, data=data
    )  # fmt: skip


def main() -> None:
    """Run the node until Ctrl-C or shutdown."""
    run_node("camera", CameraNode)


if __name__ == "__main__":
    main()
