"""The perception node observes, refuses what it cannot use and remembers, with real messages in a domain of its own."""

from __future__ import annotations

import importlib.util
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rclpy
from geometry_msgs.msg import TransformStamped
from mbd_model.errors import MbdError
from mbd_model.ros.conversions import scene_from_msg
from mbd_msgs.srv import Observe
from mbd_perception.ros.node import PerceptionNode
from mbd_perception.synthetic.render import render
from perception_rig import FRAME, POSE, QUATERNION, SMALL, SOLIDS, Rig, cloud, filled, good_images, image
from rclpy.parameter import Parameter
from sensor_msgs.msg import Image, PointCloud2, PointField


@pytest.mark.parametrize("kind", ["images", "points"])
def test_observe(rig: Callable[..., Rig], kind: str) -> None:
    """Images and clouds alike become a latched scene with ids that show source or target."""
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


def test_another_segmenter(rig: Callable[..., Rig], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A segmenter of somebody else that fails on a frame is the answer to it; the frame is kept, the node lives on."""
    (tmp_path / "moody.py").write_text(
        "from mbd_perception.segmenters.blobs import blob_segmenter\n"
        "def make():\n"
        "    ours, calls = blob_segmenter(), []\n"
        "    def labels(frame):\n"
        "        calls.append(1)\n"
        "        return ours(frame) if len(calls) > 1 else ours(frame)[:7]\n"
        "    return labels\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    table = rig(good_images, segmenter="moody:make", state_dir=str(tmp_path / "state"))
    refused = table.observe()
    assert not refused.success
    assert "labels of shape (7, 320)" in refused.message
    assert (tmp_path / "state/failed_frames/frame_1/depth.png").is_file()
    answer = table.observe()
    assert answer.success, answer.message
    assert [o.color_name for o in scene_from_msg(answer.scene).objects] == ["red", "blue"]


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
    """A node that comes back states its last scene again, camera or not."""
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
    """Where tf2 is installed it states where the camera stands: the scene is that of the same pose as a parameter."""
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
    """Asking for tf2 where it is not installed states what to do instead."""
    if importlib.util.find_spec("tf2_ros") is not None:
        pytest.skip("tf2_ros is installed here")
    with pytest.raises(MbdError, match="tf2_ros is not installed"):
        PerceptionNode(context=context, parameter_overrides=[Parameter("camera_pose", value="tf")])
