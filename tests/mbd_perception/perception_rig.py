"""A perception node and a camera in one executor, with real messages in a domain of their own."""

from __future__ import annotations

import array
from collections.abc import Callable
from typing import Any

import numpy as np
import rclpy
from builtin_interfaces.msg import Time
from mbd_model.camera.intrinsics import Intrinsics
from mbd_model.ros.qos import LATCHED, SENSOR
from mbd_msgs.msg import Scene
from mbd_msgs.srv import Observe
from mbd_perception.frames.frame import RgbdFrame
from mbd_perception.ros.node import PerceptionNode
from mbd_perception.synthetic.render import KINECT, Box, Cylinder, looking_at, render
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from sensor_msgs.msg import CameraInfo, Image, PointCloud2, PointField

POSE = looking_at((0.6, 0.0, 1.1), (0.6, 0.0, 0.0))
SOLIDS = [Box((0.5, 0.2, 0.0), (0.06, 0.06, 0.06), (200, 40, 40)), Cylinder((0.8, 0, 0), 0.04, 0.1, (40, 40, 200))]
SMALL = Intrinsics(fx=KINECT.fx / 2, fy=KINECT.fy / 2, cx=159.75, cy=119.75, width=320, height=240)
FRAME = render(SOLIDS, POSE, np.random.default_rng(0), camera=SMALL).frame
TOPICS = {
    "color": (Image, "camera/color/image_raw"),
    "depth": (Image, "camera/depth/image_raw"),
    "info": (CameraInfo, "camera/color/camera_info"),
    "points": (PointCloud2, "camera/points"),
}
QUATERNION = [-0.7071067811865476, 0.7071067811865476, 0.0, 0.0]


def filled(values: np.ndarray) -> array.array:
    """Bytes of an array as rclpy takes them without copying element by element."""
    data = array.array("B")
    data.frombytes(np.ascontiguousarray(values).tobytes())
    return data


def image(values: np.ndarray, encoding: str) -> Image:
    """An image message."""
    height, width = values.shape[:2]
    return Image(height=height, width=width, encoding=encoding, step=values[0].nbytes, data=filled(values))


def cloud(frame: RgbdFrame) -> PointCloud2:
    """An organized cloud, NaN where there is no depth."""
    columns, rows = frame.camera.rays()
    z = np.where(frame.depth > 0, frame.depth, np.nan)
    rgb = frame.color.astype(np.uint32)
    packed = ((rgb[..., 0] << 16) | (rgb[..., 1] << 8) | rgb[..., 2]).view(np.float32)
    points = np.stack([columns * z, rows * z, z, packed], axis=-1).astype(np.float32)
    fields = [PointField(name=n, offset=4 * i, datatype=7, count=1) for i, n in enumerate(("x", "y", "z", "rgb"))]
    return PointCloud2(
        height=240, width=320, fields=fields, point_step=16, row_step=16 * 320, data=filled(points), is_dense=False
    )


class Camera(Node):
    """Publishes what ``messages`` returns, stamped now, 20 times a second; and asks perception to observe."""

    def __init__(self, context: rclpy.Context, messages: Callable[[], dict[str, object]]) -> None:
        super().__init__("camera", context=context)
        self.messages = messages
        self.fixed_stamp: Time | None = None
        self.stamps: dict[str, Time] = {}
        self._out: dict[str, Publisher[Any]] = {}
        self.offer(SENSOR)
        self.create_timer(0.05, self.shoot)
        self.client = self.create_client(Observe, "perception/observe")
        self.scenes: list[Scene] = []
        self.create_subscription(Scene, "perception/source_scene", self.scenes.append, LATCHED)

    def offer(self, profile: QoSProfile) -> None:
        """Publish with that quality of service from now on."""
        for key in tuple(self._out):
            self.silence(key)
        self._out = {key: self.create_publisher(kind, topic, profile) for key, (kind, topic) in TOPICS.items()}

    def silence(self, key: str) -> None:
        """Offer a topic no longer."""
        self.destroy_publisher(self._out.pop(key))

    def shoot(self) -> None:
        """Publish one moment."""
        stamp = self.get_clock().now().to_msg()
        for key, message in self.messages().items():
            message.header.stamp = self.fixed_stamp or self.stamps.get(key, stamp)
            self._out[key].publish(message)


def good_images() -> dict[str, object]:
    """Colour, depth and camera_info as they should be."""
    k = [SMALL.fx, 0.0, SMALL.cx, 0.0, SMALL.fy, SMALL.cy, 0.0, 0.0, 1.0]
    return {
        "info": CameraInfo(width=320, height=240, k=k),
        "color": image(FRAME.color, "rgb8"),
        "depth": image(np.rint(FRAME.depth * 1000).astype(np.uint16), "16UC1"),
    }


class Rig:
    """A perception node and a camera in one executor."""

    def __init__(self, context: rclpy.Context, messages: Callable[[], dict[str, object]], **parameters: object) -> None:
        settings = {"camera_position": [0.6, 0.0, 1.1], "camera_orientation": QUATERNION, "timeout": 3.0} | parameters
        overrides = [Parameter(name, value=value) for name, value in settings.items()]
        self.node = PerceptionNode(context=context, parameter_overrides=overrides)
        self.camera = Camera(context, messages)
        self.executor = SingleThreadedExecutor(context=context)
        self.executor.add_node(self.node)
        self.executor.add_node(self.camera)

    def observe(self, role: int = Observe.Request.SOURCE) -> Observe.Response:
        """Ask and wait for the answer."""
        assert self.camera.client.wait_for_service(10.0)
        future = self.camera.client.call_async(Observe.Request(role=role))
        self.executor.spin_until_future_complete(future, timeout_sec=20.0)
        assert future.done()
        return future.result()

    def close(self) -> None:
        """End both nodes."""
        self.executor.shutdown()
        self.node.destroy_node()
        self.camera.destroy_node()
