"""Streams as cameras offer them: compressed, reliable or not, unevenly stamped, changing, in other units."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
import pytest
import rclpy
from builtin_interfaces.msg import Time
from compressing import png, quantised, rvl, with_header
from mbd_model.camera.intrinsics import Intrinsics
from mbd_model.ros.conversions import stamp_from_msg, stamp_to_msg
from mbd_model.ros.offered import OfferedSubscription, StreamSource, strongest_qos
from mbd_model.ros.qos import EVENTS, LATCHED, SENSOR
from mbd_perception.synthetic.render import render
from perception_rig import FRAME, POSE, SMALL, SOLIDS, Rig, cloud, filled, good_images, image
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CameraInfo, CompressedImage
from std_msgs.msg import String

MILLIMETRES = np.rint(FRAME.depth * 1000).astype(np.uint16)
INVERSE, SCALE, SHIFT = quantised(FRAME.depth)
DEPTHS = {
    "16UC1; compressedDepth png": with_header(png(MILLIMETRES)),
    "16UC1; compressedDepth rvl": with_header(rvl(MILLIMETRES)),
    "32FC1; compressedDepth png": with_header(png(INVERSE), SCALE, SHIFT),
    "32FC1; compressedDepth rvl": with_header(rvl(INVERSE), SCALE, SHIFT),
}
JPEG = cv2.imencode(".jpg", FRAME.color[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 95])[1].tobytes()


def info_of(camera: Intrinsics, width: int | None = None, height: int | None = None) -> CameraInfo:
    """The camera_info of a camera, under other sizes where they are given."""
    k = [camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0]
    return CameraInfo(width=width or camera.width, height=height or camera.height, k=k)


def packed(form: str, data: bytes) -> CompressedImage:
    """A compressed image."""
    return CompressedImage(format=form, data=filled(np.frombuffer(data, np.uint8)))


@pytest.mark.parametrize("form", DEPTHS)
@pytest.mark.parametrize("transport", ["auto", "compressed"])
def test_compressed(rig: Callable[..., Rig], form: str, transport: str) -> None:
    """From a camera that publishes compressed images only, the same scene comes, asked for by parameter or not."""
    table = rig(dict, image_transport=transport)
    color = table.camera.create_publisher(CompressedImage, "camera/color/image_raw/compressed", SENSOR)
    depth = table.camera.create_publisher(CompressedImage, "camera/depth/image_raw/compressedDepth", SENSOR)
    for topic in ("color", "depth"):
        table.camera.silence(topic)

    def shoot() -> dict[str, object]:
        stamp = table.camera.get_clock().now().to_msg()
        for publisher, message in (
            (color, packed("rgb8; jpeg compressed bgr8", JPEG)),
            (depth, packed(form, DEPTHS[form])),
        ):
            message.header.stamp = stamp
            publisher.publish(message)
        return {"info": good_images()["info"]}

    table.camera.messages = shoot
    answer = table.observe()
    assert answer.success, answer.message
    assert [o.color_name for o in answer.scene.objects] == ["red", "blue"]


@pytest.mark.parametrize("transport", ["raw", "compressed"])
def test_transport_missing(rig: Callable[..., Rig], transport: str) -> None:
    """Told to listen to what nobody publishes, the answer names the topics it listened to."""
    table = rig(dict, image_transport=transport, timeout=0.3)
    answer = table.observe()
    suffix = "" if transport == "raw" else "/compressed"
    assert f"camera/color/image_raw{suffix})" in answer.message
    assert f"camera/depth/image_raw{suffix and '/compressedDepth'})" in answer.message


@pytest.mark.parametrize("offered", ["reliable", "best effort", "latched", "mixed"])
def test_asked_as_offered(context: rclpy.Context, offered: str) -> None:
    """Asked for reliably exactly where every publisher sends reliably, and latched where it is latched."""
    profiles = {"reliable": [EVENTS], "best effort": [SENSOR], "latched": [LATCHED], "mixed": [EVENTS, SENSOR]}[offered]
    node = rclpy.create_node("camera", context=context)
    listener = rclpy.create_node("perception", context=context)
    executor = rclpy.executors.SingleThreadedExecutor(context=context)
    executor.add_node(listener)
    received: list[String] = []
    publishers = [node.create_publisher(String, "stream", profile) for profile in profiles]
    publishers[0].publish(String(data="first"))
    stream = OfferedSubscription(listener, [StreamSource(String, "stream")], received.append)
    while stream.reliable != (offered in ("reliable", "latched")) or len(asked(node)) != 1:
        executor.spin_once(timeout_sec=1.0)
    while asked(node)[0].reliability != (
        ReliabilityPolicy.RELIABLE if stream.reliable else ReliabilityPolicy.BEST_EFFORT
    ):
        executor.spin_once(timeout_sec=0.1)
    assert (asked(node)[0].durability == DurabilityPolicy.TRANSIENT_LOCAL) == (offered == "latched")
    while not received:  # of a latched one the first, published before anybody listened
        executor.spin_once(timeout_sec=0.1)
        if offered != "latched":
            publishers[-1].publish(String(data="later"))
    assert received[0].data == ("first" if offered == "latched" else "later")
    executor.shutdown()
    node.destroy_node()
    listener.destroy_node()


def asked(node: rclpy.node.Node) -> list[QoSProfile]:
    """How the stream is subscribed to."""
    return [e.qos_profile for e in node.get_subscriptions_info_by_topic("stream")]


def test_strongest() -> None:
    """Without publishers what any serves is asked for."""
    assert strongest_qos([]).reliability == ReliabilityPolicy.BEST_EFFORT
    assert strongest_qos([LATCHED, EVENTS]).durability == DurabilityPolicy.VOLATILE
    assert strongest_qos([LATCHED, EVENTS]).reliability == ReliabilityPolicy.RELIABLE


@pytest.mark.parametrize(("first", "then"), [(SENSOR, EVENTS), (EVENTS, SENSOR)])
def test_driver_restarted(rig: Callable[..., Rig], first: QoSProfile, then: QoSProfile) -> None:
    """A driver that comes back and offers its images otherwise is listened to again."""
    table = rig(good_images, timeout=5.0)
    for profile in (first, then):
        table.camera.offer(profile)
        answer = table.observe()
        assert answer.success, answer.message


@pytest.mark.parametrize("period", [0.1, 1 / 15, 1 / 30])
@pytest.mark.parametrize("late", ["color", "depth"])
def test_apart(rig: Callable[..., Rig], period: float, late: str) -> None:
    """Colour and depth stamped 33 ms apart are one frame, at any rate of the camera."""
    table = rig(good_images)
    count = itertools.count()
    start = stamp_from_msg(table.camera.get_clock().now().to_msg()) + 10**9

    def shifted() -> dict[str, object]:
        messages: dict[str, Any] = good_images()
        moment = start + int(next(count) * period * 1e9)
        stamps = {key: stamp_to_msg(moment + (33_000_000 if key == late else 0)) for key in messages}
        table.camera.stamps = stamps
        return messages

    table.camera.messages = shifted
    answer = table.observe()
    assert answer.success, answer.message
    assert len(answer.scene.objects) == 2


@pytest.mark.parametrize("frames", [1, 3])
def test_size_changes(rig: Callable[..., Rig], frames: int) -> None:
    """A camera that goes on in another size, amid an observation or between two, is seen in its new size."""
    table = rig(good_images, frames=frames)
    first = table.observe()
    big = Intrinsics(fx=393.75, fy=393.75, cx=239.5, cy=179.5, width=480, height=360)
    view = render(SOLIDS, POSE, np.random.default_rng(1), camera=big).frame
    larger = {
        "color": image(view.color, "rgb8"),
        "depth": image(np.rint(view.depth * 1000).astype(np.uint16), "16UC1"),
        "info": info_of(big),  # last: the images of the new size come before it
    }
    count = itertools.count()
    table.camera.messages = lambda: good_images() if next(count) < 2 else larger
    for _ in range(2):
        answer = table.observe()
        assert answer.success, answer.message
        assert len(answer.scene.objects) == len(first.scene.objects) == 2
    table.camera.messages = good_images
    assert table.observe().success


def test_portrait(rig: Callable[..., Rig]) -> None:
    """Images turned upright, camera_info left as it was: heights are those of the things."""
    turned = [np.ascontiguousarray(np.rot90(values)) for values in (FRAME.color, MILLIMETRES)]
    messages = {"color": image(turned[0], "rgb8"), "depth": image(turned[1], "16UC1"), "info": info_of(SMALL)}
    answer = rig(lambda: messages, camera_pose="table").observe()
    assert answer.success, answer.message
    assert sorted(o.size.z for o in answer.scene.objects) == pytest.approx([0.06, 0.1], abs=0.01)


def millimetre_float() -> dict[str, object]:
    """Depth in float millimetres."""
    return good_images() | {"depth": image((1000 * FRAME.depth).astype(np.float32), "32FC1")}


def saturated() -> dict[str, object]:
    """Depth of 65535 everywhere."""
    return good_images() | {"depth": image(np.full_like(MILLIMETRES, 65535), "16UC1")}


def tenths() -> dict[str, object]:
    """Depth in tenths of a millimetre."""
    return good_images() | {"depth": image(10 * MILLIMETRES, "16UC1")}


def fifths() -> dict[str, object]:
    """Depth in fifths of a millimetre, as RealSense cameras may be set to."""
    return good_images() | {"depth": image(5 * MILLIMETRES, "16UC1")}


def metres_as_millimetres() -> dict[str, object]:
    """Depth in whole metres."""
    return good_images() | {"depth": image(np.ones_like(MILLIMETRES), "16UC1")}


def millimetre_cloud() -> dict[str, object]:
    """A cloud in millimetres."""
    message = cloud(FRAME)
    values = np.frombuffer(message.data, np.float32).reshape(-1, 4).copy()
    values[:, :3] *= 1000
    message.data = filled(values)
    return {"points": message}


@pytest.mark.parametrize(
    ("messages", "words"),
    [
        (millimetre_float, "publish metres"),
        (millimetre_cloud, "publish metres"),
        (saturated, "saturated at 65535"),
        (tenths, "tenths of a millimetre"),
        (fifths, "units of 0.2 mm"),
        (metres_as_millimetres, "metres taken for millimetres"),
    ],
)
@pytest.mark.parametrize("pose", ["parameter", "table"])
def test_units(rig: Callable[..., Rig], messages: Callable[[], dict[str, object]], words: str, pose: str) -> None:
    """Depth in other units is answered with what it may be, whether the camera's pose is known or not."""
    kind = "points" if "points" in messages() else "images"
    table = rig(messages, input=kind, camera_pose=pose)
    answer = table.observe()
    assert words in answer.message
    table.camera.messages = good_images if kind == "images" else lambda: {"points": cloud(FRAME)}
    assert table.observe().success


def test_odd_stamp(rig: Callable[..., Rig]) -> None:
    """Stamps beyond what a Time holds again are answered, and the next observation is not held up by them."""
    table = rig(good_images, timeout=1.0)
    table.camera.fixed_stamp = Time(sec=2**31 - 1, nanosec=2**32 - 1)
    assert table.observe().message
    table.camera.fixed_stamp = None
    answer = table.observe()
    assert answer.success, answer.message
