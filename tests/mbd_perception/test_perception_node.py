"""The perception node, with real messages in a domain of its own."""

from __future__ import annotations

import array
import importlib.util
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rclpy
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import TransformStamped
from mbd_model.conversions import scene_from_msg
from mbd_model.errors import MbdError
from mbd_model.qos import EVENTS, LATCHED, SENSOR
from mbd_msgs.msg import Scene
from mbd_msgs.srv import Observe
from mbd_perception.frame import Intrinsics, RgbdFrame
from mbd_perception.node import PerceptionNode
from mbd_perception.synthetic import KINECT, Box, Cylinder, looking_at, render
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import CameraInfo, Image, PointCloud2, PointField
from visualization_msgs.msg import Marker, MarkerArray

POSE = looking_at((0.6, 0.0, 1.1), (0.6, 0.0, 0.0))
SOLIDS = [Box((0.5, 0.2, 0.0), (0.06, 0.06, 0.06), (200, 40, 40)), Cylinder((0.8, 0, 0), 0.04, 0.1, (40, 40, 200))]
SMALL = Intrinsics(fx=KINECT.fx / 2, fy=KINECT.fy / 2, cx=159.75, cy=119.75, width=320, height=240)
FRAME = render(SOLIDS, POSE, np.random.default_rng(0), camera=SMALL).frame
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
        topics = {
            "color": (Image, "camera/color/image_raw"),
            "depth": (Image, "camera/depth/image_raw"),
            "info": (CameraInfo, "camera/color/camera_info"),
            "points": (PointCloud2, "camera/points"),
        }
        self._out = {key: self.create_publisher(kind, topic, SENSOR) for key, (kind, topic) in topics.items()}
        self.create_timer(0.05, self.shoot)
        self.client = self.create_client(Observe, "perception/observe")
        self.scenes: list[Scene] = []
        self.create_subscription(Scene, "perception/source_scene", self.scenes.append, LATCHED)

    def shoot(self) -> None:
        """Publish one moment."""
        stamp = self.get_clock().now().to_msg()
        for key, message in self.messages().items():
            message.header.stamp = self.fixed_stamp or stamp
            self._out[key].publish(message)


def good_images() -> dict[str, object]:
    """Colour, depth and camera_info as they should be."""
    k = [SMALL.fx, 0.0, SMALL.cx, 0.0, SMALL.fy, SMALL.cy, 0.0, 0.0, 1.0]
    return {
        "info": CameraInfo(width=320, height=240, k=k),
        "color": image(FRAME.color, "rgb8"),
        "depth": image(np.rint(FRAME.depth * 1000).astype(np.uint16), "16UC1"),
    }


@pytest.fixture
def context(ros_domain: int) -> Iterator[rclpy.Context]:
    """ROS in a domain of its own."""
    own = rclpy.Context()
    rclpy.init(context=own, domain_id=ros_domain)
    yield own
    own.try_shutdown()


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


@pytest.fixture
def rig(context: rclpy.Context) -> Iterator[Callable[..., Rig]]:
    """Makes rigs and ends them."""
    made: list[Rig] = []

    def make(messages: Callable[[], dict[str, object]], **parameters: object) -> Rig:
        made.append(Rig(context, messages, **parameters))
        return made[-1]

    yield make
    for one in made:
        one.close()


@pytest.mark.parametrize("kind", ["images", "points"])
def test_observe(rig: Callable[..., Rig], kind: str) -> None:
    """Images and clouds alike become a latched scene with ids that say source or target."""
    table = rig(good_images if kind == "images" else lambda: {"points": cloud(FRAME)}, input=kind)
    answer = table.observe()
    assert answer.success, answer.message
    scene = scene_from_msg(answer.scene)
    assert scene.ids == ("s1", "s2")
    assert [o.color_name for o in scene.objects] == ["red", "blue"]
    assert answer.scene.table_plane == pytest.approx([0, 0, 1, 0], abs=0.01)
    while not table.camera.scenes:
        table.executor.spin_once(timeout_sec=1.0)
    assert table.camera.scenes[0] == answer.scene
    assert scene_from_msg(table.observe(Observe.Request.TARGET).scene).ids == ("t1", "t2")


def wrong_encoding() -> dict[str, object]:
    """Depth in an encoding that is none."""
    return good_images() | {"depth": image(FRAME.color, "rgb8")}


def mismatched() -> dict[str, object]:
    """Depth of another size than colour."""
    return good_images() | {"depth": image(np.ones((120, 160), dtype=np.uint16), "16UC1")}


def cut_off() -> dict[str, object]:
    """A depth image whose data ends early."""
    message = good_images()["depth"]
    assert isinstance(message, Image)
    message.data = message.data[:1000]
    return good_images() | {"depth": message}


def blind() -> dict[str, object]:
    """No depth anywhere."""
    return good_images() | {"depth": image(np.zeros((240, 320), dtype=np.uint16), "16UC1")}


def no_depth() -> dict[str, object]:
    """Colour only."""
    return {k: v for k, v in good_images().items() if k != "depth"}


@pytest.mark.parametrize(
    ("messages", "words"),
    [
        (wrong_encoding, "expected 16UC1"),
        (mismatched, "registered to colour"),
        (cut_off, "cut off"),
        (blind, "all zero or NaN"),
        (no_depth, r"no depth \(camera/depth/image_raw\) arrived"),
        (dict, "start the camera"),
    ],
)
def test_bad_input(rig: Callable[..., Rig], messages: Callable[[], dict[str, object]], words: str) -> None:
    """Bad input is answered with what was wrong; the node lives on and sees the table once the camera is right."""
    table = rig(messages, timeout=0.7)
    answer = table.observe()
    assert not answer.success
    assert re.search(words, answer.message), answer.message
    table.camera.messages = good_images
    again = table.observe()
    assert again.success, again.message


@pytest.mark.parametrize("data", [np.full((240, 320, 3), np.nan, dtype=np.float32), np.zeros(0, dtype=np.float32)])
def test_bad_cloud(rig: Callable[..., Rig], data: np.ndarray) -> None:
    """A cloud that is empty or all NaN is answered with a reason."""
    height, width = data.shape[:2] if data.size else (0, 0)
    fields = [PointField(name=n, offset=4 * i, datatype=7, count=1) for i, n in enumerate("xyz")]
    message = PointCloud2(
        height=height, width=width, fields=fields, point_step=12, row_step=12 * width, data=filled(data)
    )
    answer = rig(lambda: {"points": message}, input="points").observe()
    assert not answer.success
    assert "check that the camera" in answer.message


def test_unknown_role(rig: Callable[..., Rig]) -> None:
    """A role that is neither source nor target is refused at once."""
    answer = rig(good_images).observe(7)
    assert not answer.success
    assert "role 7" in answer.message


def test_restart(rig: Callable[..., Rig], context: rclpy.Context, tmp_path: Path) -> None:
    """A node that comes back says its last scene again, camera or not."""
    first = rig(good_images, state_dir=str(tmp_path))
    answer = first.observe()
    first.node.destroy_node()
    second = rig(dict, state_dir=str(tmp_path))
    while not second.camera.scenes:
        second.executor.spin_once(timeout_sec=5.0)
    assert second.camera.scenes[0] == answer.scene


def test_old_frames(rig: Callable[..., Rig]) -> None:
    """Frames stamped before the request are not used: the table may have changed since."""
    table = rig(good_images, timeout=0.7)
    table.camera.fixed_stamp = table.camera.get_clock().now().to_msg()
    answer = table.observe()
    assert not answer.success
    assert "stamped before the request" in answer.message


def test_live(rig: Callable[..., Rig]) -> None:
    """Whoever listens gets objects live, under the ids of the last observation, and a picture of them."""
    table = rig(good_images)
    observed = table.observe(Observe.Request.TARGET)
    scenes: list[Scene] = []
    pictures: list[Image] = []
    table.camera.create_subscription(Scene, "perception/live_scene", scenes.append, SENSOR)
    table.camera.create_subscription(Image, "perception/live_image", pictures.append, SENSOR)
    while len(scenes) < 3 or not pictures:
        table.executor.spin_once(timeout_sec=5.0)
    assert {o.id for o in scenes[-1].objects} == {o.id for o in observed.scene.objects}
    assert (pictures[0].width, pictures[0].height, pictures[0].encoding) == (320, 240, "rgb8")


def test_shown(rig: Callable[..., Rig]) -> None:
    """An observation is shown by markers and an annotated picture; diagnostics say rate, latency, table and objects."""
    table = rig(good_images)
    markers: list[MarkerArray] = []
    pictures: list[Image] = []
    reports: list[DiagnosticArray] = []
    answer = table.observe()
    table.camera.create_subscription(MarkerArray, "perception/markers", markers.append, LATCHED)
    table.camera.create_subscription(Image, "perception/image", pictures.append, LATCHED)
    table.camera.create_subscription(DiagnosticArray, "diagnostics", reports.append, EVENTS)
    while not (markers and pictures and len(reports) > 1):
        table.executor.spin_once(timeout_sec=5.0)
    shown = [m for m in markers[0].markers if m.action == Marker.ADD]
    assert {m.text.split()[0] for m in shown if m.type == Marker.TEXT_VIEW_FACING} == {"s1", "s2"}
    for box, obj in zip([m for m in shown if m.type == Marker.CUBE], answer.scene.objects, strict=True):
        assert (box.pose.position.x, box.pose.position.y) == pytest.approx(
            (obj.box_center.x, obj.box_center.y), abs=0.02
        )
    assert (pictures[0].width, pictures[0].height) == (320, 240)
    picture = np.frombuffer(pictures[0].data, np.uint8).reshape(240, 320, 3)
    assert (picture != FRAME.color).any()
    values = {v.key: v.value for v in reports[-1].status[0].values}
    assert values["table found"] == "True"
    assert values["objects"] == "2"
    assert float(values["frame rate [Hz]"]) > 0
    assert float(values["latency of the last observation [ms]"]) > 0
    assert reports[-1].status[0].level == DiagnosticStatus.OK


def test_drops_frames(rig: Callable[..., Rig]) -> None:
    """Frames that come while it is busy are dropped: what it shows next is of now, however many came meanwhile."""
    table = rig(good_images)
    scenes: list[Scene] = []
    table.camera.create_subscription(Scene, "perception/live_scene", scenes.append, SENSOR)
    while not scenes:
        table.executor.spin_once(timeout_sec=5.0)
    for _ in range(60):  # perception is not served meanwhile
        table.camera.shoot()
    last = table.camera.get_clock().now().nanoseconds
    scenes.clear()
    old = 0
    while not scenes or stamp_of(scenes[-1]) < last:
        table.executor.spin_once(timeout_sec=5.0)
        old = sum(stamp_of(s) < last for s in scenes)
    assert old <= 12


def stamp_of(scene: Scene) -> int:
    """Stamp of a scene [ns]."""
    return scene.header.stamp.sec * 1_000_000_000 + scene.header.stamp.nanosec


def test_ids_last(rig: Callable[..., Rig]) -> None:
    """Observed again after an object was taken away, the others keep their ids."""
    table = rig(good_images)
    first = table.observe()
    alone = render(SOLIDS[1:], POSE, np.random.default_rng(1), camera=SMALL).frame
    table.camera.messages = lambda: (
        good_images()
        | {
            "color": image(alone.color, "rgb8"),
            "depth": image(np.rint(alone.depth * 1000).astype(np.uint16), "16UC1"),
        }
    )
    second = table.observe()
    assert [o.id for o in first.scene.objects] == ["s1", "s2"]
    assert [o.id for o in second.scene.objects] == ["s2"]


def test_tf(rig: Callable[..., Rig]) -> None:
    """Where tf2 is installed it says where the camera stands: the scene is that of the same pose as a parameter."""
    tf2_ros = pytest.importorskip("tf2_ros", reason="tf2_ros is not among the wheels; it is on a normal ROS 2 install")

    def framed() -> dict[str, object]:
        messages: dict[str, Any] = good_images()
        for message in messages.values():
            message.header.frame_id = "camera_optical"
        return messages

    first = rig(framed)
    expected = first.observe()
    first.node.destroy_node()
    table = rig(framed, camera_pose="tf")
    camera2base = TransformStamped(child_frame_id="camera_optical")
    camera2base.header.frame_id = "j2n6s300_link_base"
    camera2base.transform.translation.x, camera2base.transform.translation.z = 0.6, 1.1
    rotation = camera2base.transform.rotation
    rotation.x, rotation.y, rotation.z, rotation.w = QUATERNION
    tf2_ros.StaticTransformBroadcaster(table.camera).sendTransform(camera2base)
    answer = table.observe()
    for _ in range(20):  # until the transform has come
        if "tf2 knows no transform" not in answer.message:
            break
        answer = table.observe()
    assert answer.success, answer.message
    for seen, known in zip(answer.scene.objects, expected.scene.objects, strict=True):
        assert (seen.centroid.x, seen.centroid.y) == pytest.approx((known.centroid.x, known.centroid.y), abs=1e-3)


def test_tf_missing(context: rclpy.Context) -> None:
    """Asking for tf2 where it is not installed says what to do instead."""
    if importlib.util.find_spec("tf2_ros") is not None:
        pytest.skip("tf2_ros is installed here")
    with pytest.raises(MbdError, match="tf2_ros is not installed"):
        PerceptionNode(context=context, parameter_overrides=[Parameter("camera_pose", value="tf")])
