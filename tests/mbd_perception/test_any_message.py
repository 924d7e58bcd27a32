"""Whatever messages a camera's driver publishes, the node answers every frame and lives on."""

from __future__ import annotations

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mbd_model.ros.qos import SENSOR
from mbd_msgs.msg import Scene
from mbd_perception.ros import node as perception_node
from mbd_perception.ros.camera_conversions import BAYER_ENCODINGS, COLOR_ENCODINGS, YUV_ENCODINGS
from perception_rig import FRAME, Rig, cloud, filled, good_images, image
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import CameraInfo, Image, PointCloud2, PointField, RegionOfInterest

ENCODINGS = [*COLOR_ENCODINGS, *YUV_ENCODINGS, *BAYER_ENCODINGS, "16UC1", "32FC1", "64FC1", "", "nonsense"]
ODD = st.sampled_from([0.0, -1.0, 1e-38, 1e-6, 0.5, 1e9, 3e38, np.nan, np.inf, -np.inf])
SIZES = st.sampled_from([0, 1, 2, 7, 16, 240, 320])
WORDS = st.integers(0, 2**32 - 1)


@st.composite
def images(draw: st.DrawFn) -> Image:
    """An image of any encoding, size and row length, with as many bytes as it may have."""
    height, width, channels = draw(SIZES), draw(SIZES), draw(st.integers(1, 8))
    size = draw(st.sampled_from([0, 1, height * width * channels, 1000]))
    data = np.random.default_rng(draw(st.integers(0, 99))).integers(0, 256, size).astype(np.uint8)
    step = draw(st.sampled_from([0, width, width * channels, 2**31]))
    return Image(height=height, width=width, encoding=draw(st.sampled_from(ENCODINGS)), step=step, data=filled(data),
                 is_bigendian=draw(st.integers(0, 1)))  # fmt: skip


@st.composite
def depths(draw: st.DrawFn) -> Image:
    """A depth image of the right size with values that no table has."""
    base = draw(st.sampled_from([FRAME.depth, np.ones_like(FRAME.depth), 0 * FRAME.depth]))
    values = (base * np.float32(draw(st.sampled_from([1.0, 1e-3, 5.0, 10.0, 1000.0])))).astype(np.float32)
    rng = np.random.default_rng(draw(st.integers(0, 99)))
    values[rng.random(values.shape) < draw(st.sampled_from([0.0, 0.3, 1.0]))] = draw(ODD)
    if draw(st.booleans()):
        return image(values, "32FC1")
    with np.errstate(all="ignore"):
        return image(np.nan_to_num(values * 1000).clip(0, 65535).astype(np.uint16), "16UC1")


@st.composite
def infos(draw: st.DrawFn) -> CameraInfo:
    """A camera_info with numbers that no camera has."""
    info: Any = copy.deepcopy(good_images()["info"])
    if draw(st.booleans()):
        info.k[draw(st.sampled_from([0, 2, 4, 5]))] = draw(ODD)
    if draw(st.booleans()):
        info.width, info.height = draw(SIZES), draw(SIZES)
    info.binning_x, info.binning_y = draw(st.sampled_from([(0, 0), (1, 1), (2, 2), (2**31, 7)]))
    if draw(st.booleans()):
        info.roi = RegionOfInterest(x_offset=draw(WORDS), width=draw(SIZES), height=draw(SIZES))
    return info


@st.composite
def clouds(draw: st.DrawFn) -> PointCloud2:
    """A cloud whose layout may be anything."""
    message = cloud(FRAME)
    values = np.frombuffer(message.data, np.float32).reshape(-1, 4).copy()
    values[:: draw(st.integers(1, 3)), : draw(st.integers(0, 3))] = draw(ODD)
    with np.errstate(all="ignore"):
        values[:, :3] *= np.float32(draw(st.sampled_from([1.0, 1000.0, -1.0])))
    message.data = filled(values[: draw(st.sampled_from([0, 10, len(values)]))])
    if draw(st.booleans()):
        message.height, message.width = draw(SIZES), draw(SIZES)
        message.point_step, message.row_step = draw(st.sampled_from([0, 4, 16, 2**31])), draw(WORDS)
    if draw(st.booleans()):
        names = draw(st.lists(st.sampled_from(["x", "y", "z", "rgb", "rgba", "r"]), max_size=5))
        message.fields = [PointField(name=n, offset=draw(WORDS), datatype=draw(st.integers(0, 9))) for n in names]
    return message


def framed(message: Any, frame_id: str) -> Any:
    """A message in a frame."""
    message.header.frame_id = frame_id
    return message


@st.composite
def moments(draw: st.DrawFn) -> dict[str, object]:
    """Good messages, some of them replaced by others."""
    odd: dict[str, st.SearchStrategy[Any]] = {
        "color": images(),
        "depth": st.one_of(depths(), images()),
        "info": infos(),
    }
    replaced = draw(st.sets(st.sampled_from(sorted(odd)), min_size=1))
    name = draw(st.text(max_size=5).filter(lambda t: "\0" not in t and t.isprintable()))
    return {k: framed(m, name) for k, m in (good_images() | {k: draw(odd[k]) for k in replaced}).items()}


def checked(table: Rig, messages: dict[str, object]) -> None:
    """The node answers with a scene or with a sentence."""
    table.camera.messages = lambda: messages
    answer = table.observe()
    assert answer.success == bool(answer.scene.objects)
    assert len(answer.message) > 20


@pytest.mark.parametrize("kind", ["images", "points"])
@pytest.mark.parametrize("pose", ["parameter", "table"])
def test_any_message(rig: Callable[..., Rig], kind: str, pose: str, tmp_path: Path) -> None:
    """Images, optics and clouds of any content are answered, live too; the next good frame is seen."""
    good = good_images if kind == "images" else lambda: {"points": cloud(FRAME)}
    table = rig(good, input=kind, camera_pose=pose, frames=1, timeout=1.5, state_dir=str(tmp_path))
    table.camera.create_subscription(Scene, "perception/live_scene", lambda _: None, SENSOR)

    @settings(max_examples=25, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True)
    @given(moments() if kind == "images" else clouds().map(lambda c: {"points": c}))
    def answered(messages: dict[str, object]) -> None:
        checked(table, messages)

    answered()
    table.camera.messages = good
    answer = table.observe()
    assert answer.success, answer.message
    assert not (tmp_path / "failed_frames").exists()  # nothing of all that was unexpected


def test_evidence(rig: Callable[..., Rig], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What nobody expected is answered, and kept with the messages it came as: a frame can be looked into later."""
    table = rig(good_images, frames=1, state_dir=str(tmp_path))

    def broken(*_: object, **__: object) -> None:
        raise ZeroDivisionError("a fault of ours")

    with monkeypatch.context() as patched:
        patched.setattr(perception_node, "observe", broken)
        answer = table.observe()
    assert not answer.success
    assert "ZeroDivisionError" in answer.message
    kept = tmp_path / "failed_frames" / "frame_1"
    assert str(kept) in answer.message
    assert "a fault of ours" in (kept / "error.txt").read_text()
    depth = deserialize_message((kept / "depth.cdr").read_bytes(), Image)
    assert (depth.width, depth.height, depth.encoding) == (320, 240, "16UC1")
    assert (kept / "depth.png").is_file()
    assert table.observe().success
