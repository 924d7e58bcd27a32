"""A camera process: 640x480 colour and depth at a rate, numbered in camera_info; prints how many frames it sent."""

from __future__ import annotations

import array
import sys
import time

import cv2
import numpy as np
import rclpy
from mbd_model.ros.qos import SENSOR
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, Image

HEIGHT, WIDTH = 480, 640


def images(rng: np.random.Generator, number: int) -> list[tuple[Image, Image]]:
    """Frames of a table in the noise of a depth camera: neither constant nor pure noise."""
    smooth = cv2.resize(rng.integers(0, 256, (12, 16, 3), dtype=np.uint8), (WIDTH, HEIGHT))
    plane = np.linspace(700, 1300, HEIGHT)[:, None] + np.zeros(WIDTH)
    made = []
    for _ in range(number):
        color = cv2.add(smooth, rng.integers(0, 12, smooth.shape, dtype=np.uint8))
        depth = (plane + rng.normal(0.0, 2.0, plane.shape)).astype(np.uint16)
        pair = []
        for pixels, encoding in ((color, "rgb8"), (depth, "16UC1")):
            msg = Image(height=HEIGHT, width=WIDTH, encoding=encoding, step=pixels[0].nbytes)
            msg.header.frame_id = "camera_color_optical_frame"
            data = array.array("B")
            data.frombytes(memoryview(pixels).cast("B"))
            msg.data = data
            pair.append(msg)
        made.append((pair[0], pair[1]))
    return made


def main(rate: float, seconds: float, camera: str = "camera") -> None:
    rclpy.init()
    node = Node(f"bench_{camera}")
    out = [node.create_publisher(Image, f"{camera}/{name}/image_raw", SENSOR) for name in ("color", "depth")]
    info = node.create_publisher(CameraInfo, f"{camera}/color/camera_info", SENSOR)
    frames = images(np.random.default_rng(0), 6)
    while not all(p.get_subscription_count() for p in (*out, info)):
        rclpy.spin_once(node, timeout_sec=0.05)
    begun = time.monotonic()
    total = round(rate * seconds)
    for number in range(total):
        # A camera's clock: to the frame's time, not for luck.
        time.sleep(max(0.0, begun + number / rate - time.monotonic()))
        stamp = node.get_clock().now().to_msg()
        for publisher, msg in zip(out, frames[number % len(frames)], strict=True):
            msg.header.stamp = stamp
            publisher.publish(msg)
        about = CameraInfo(height=HEIGHT, width=number)
        about.header.stamp = stamp
        info.publish(about)
    sys.stdout.write(f"{total} {time.monotonic() - begun:.3f}\n")
    rclpy.shutdown()


if __name__ == "__main__":
    main(float(sys.argv[1]), float(sys.argv[2]), *sys.argv[3:])
