"""From a cloud published by one process to the live Scene that another made of it, received by the first: 640x480."""

from __future__ import annotations

import array
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import rclpy
from mbd_model.ros.qos import SENSOR
from mbd_msgs.msg import Scene
from mbd_perception.synthetic.render import Box, Cylinder, looking_at, render
from rclpy.node import Node
from sensor_msgs.msg import PointCloud2, PointField

DOMAIN = 43
PERIOD_MS = 1000 / 30


def cloud() -> PointCloud2:
    """An organized cloud of a table with two things on it, 16 bytes a point."""
    solids: list[Box | Cylinder] = [
        Box((0.6, 0.15, 0.0), (0.08, 0.12, 0.1), (200, 40, 40), 0.3),
        Cylinder((0.7, -0.15, 0.0), 0.05, 0.1, (40, 40, 200), wall=0.004),
    ]
    frame = render(solids, looking_at((-0.1, 0.0, 0.7), (0.65, 0.0, 0.05)), np.random.default_rng(0)).frame
    columns, rows = frame.camera.rays()
    z = np.where(frame.depth > 0, frame.depth, np.nan)
    rgb = frame.color.astype(np.uint32)
    packed = ((rgb[..., 0] << 16) | (rgb[..., 1] << 8) | rgb[..., 2]).view(np.float32)
    data = array.array("B")
    data.frombytes(np.stack([columns * z, rows * z, z, packed], axis=-1).astype(np.float32).tobytes())
    fields = [PointField(name=n, offset=4 * i, datatype=7, count=1) for i, n in enumerate(("x", "y", "z", "rgb"))]
    return PointCloud2(height=480, width=640, fields=fields, point_step=16, row_step=16 * 640, data=data)


@pytest.fixture
def perception() -> Iterator[None]:
    """The perception node in a process of its own."""
    arguments = [sys.executable, "-m", "mbd_perception.ros.node", "--ros-args"]
    for setting in ("input:=points", "camera_pose:=table"):
        arguments += ["-p", setting]
    process = subprocess.Popen(arguments, env=os.environ | {"ROS_DOMAIN_ID": str(DOMAIN)})
    yield
    process.terminate()
    process.wait(10)


def test_round_trip(benchmark: Any, perception: None, capsys: pytest.CaptureFixture[str]) -> None:
    """Cloud published to Scene received."""
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=DOMAIN)
    node = Node("round_trip", context=context)
    executor = rclpy.executors.SingleThreadedExecutor(context=context)
    executor.add_node(node)
    out = node.create_publisher(PointCloud2, "camera/points", SENSOR)
    got: list[Scene] = []
    node.create_subscription(Scene, "perception/live_scene", got.append, SENSOR)
    message = cloud()

    def once() -> None:
        got.clear()
        message.header.stamp = node.get_clock().now().to_msg()
        deadline = time.monotonic() + 2.0
        out.publish(message)
        while not got and time.monotonic() < deadline:
            executor.spin_once(timeout_sec=0.5)

    for _ in range(20):  # until discovery has matched both ends
        once()
        if got:
            break
    assert got, "the perception node never answered"
    benchmark.pedantic(once, rounds=40, iterations=1)
    median = 1000 * benchmark.stats.stats.median
    with capsys.disabled():
        sys.stdout.write(
            f"\ncloud published to Scene received, two processes, 640x480: median {median:.1f} ms"
            f" = {median / PERIOD_MS:.2f} camera periods (30 Hz)\n"
        )
    assert len(got[0].objects) == 2
    executor.shutdown()
    context.try_shutdown()
