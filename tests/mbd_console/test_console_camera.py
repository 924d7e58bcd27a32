"""The console shows what the camera offers, compressed or not."""

from __future__ import annotations

import array

import cv2
import numpy as np
import pytest
import rclpy
from mbd_console.ros.console_node import ConsoleNode
from mbd_model.ros.qos import EVENTS
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import CompressedImage, Image

PICTURE = np.full((24, 32, 3), (200, 60, 30), np.uint8)


def raw() -> Image:
    """The picture as it is."""
    data = array.array("B", PICTURE.tobytes())
    return Image(height=24, width=32, encoding="rgb8", step=96, data=data)


def compressed() -> CompressedImage:
    """The picture as PNG."""
    data = array.array("B", cv2.imencode(".png", PICTURE[..., ::-1])[1].tobytes())
    return CompressedImage(format="rgb8; png compressed bgr8", data=data)


@pytest.mark.parametrize("message", [raw(), compressed()], ids=["raw", "compressed"])
def test_offered(ros_domain: int, message: Image | CompressedImage) -> None:
    """A picture arrives by whichever topic has a publisher."""
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=ros_domain)
    try:
        console = ConsoleNode(context=context)
        camera = rclpy.create_node("camera", context=context)
        suffix = "/compressed" if isinstance(message, CompressedImage) else ""
        publisher = camera.create_publisher(type(message), f"camera/color/image_raw{suffix}", EVENTS)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(console)
        taken: list[np.ndarray] = []
        console.desk.pictures.add = lambda _, picture: taken.append(picture)  # type: ignore[method-assign]  # to see it
        while not taken:
            publisher.publish(message)
            executor.spin_once(timeout_sec=0.1)
        np.testing.assert_array_equal(taken[0], PICTURE)
        executor.shutdown()
        console.destroy_node()
        camera.destroy_node()
    finally:
        context.try_shutdown()
