"""Of shared pictures only what lies in the table's volume stays, and no face that can be found."""

from __future__ import annotations

from array import array
from functools import cache
from pathlib import Path
from typing import Any

import cv2
import matplotlib
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_bag.errors import BagError
from mbd_bag.session.session_facts import parameter_facts
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bag.storage.message_writer import MessageWriter
from mbd_model.camera.intrinsics import Intrinsics
from mbd_model.camera.pose import pose_from_quaternion
from mbd_perception.segmentation.workspace import Workspace
from mbd_study.sharing.pictures.encodings import GREY, covered, grey, is_depth, metres, read_picture
from mbd_study.sharing.pictures.faces import FaceFinder
from mbd_study.sharing.pictures.volume import TableVolume
from mbd_study.sharing.rules import SharedPictures
from mbd_study.sharing.shared_copy import Omissions, shared_copy
from numpy.typing import NDArray
from rclpy.serialization import serialize_message
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, PointCloud2, PointField

HEIGHT, WIDTH = 480, 640
POSITION, ORIENTATION = (0.45, 0.0, 0.95), (0.5**0.5, -(0.5**0.5), 0.0, 0.0)  # straight above, robot below
CAMERA = Intrinsics(540.0, 540.0, 319.5, 239.5, WIDTH, HEIGHT)
WORKSPACE = Workspace((0.25, 0.65), (-0.4, 0.4), (-0.05, 0.5))
PARAMETERS = {
    "base_frame": "base_link",
    "camera_pose": "parameter",
    "camera_position": list(POSITION),
    "camera_orientation": list(ORIENTATION),
    "workspace_x": [0.25, 0.65],
    "workspace_y": [-0.4, 0.4],
    "workspace_z": [-0.05, 0.5],
}
VOLUME = TableVolume(CAMERA, pose_from_quaternion(POSITION, ORIENTATION), WORKSPACE, "camera", "base_link")
HEAD = (slice(150, 310), slice(60, 200))  # over the table, within the workspace
LOOKER_ON = (slice(0, 110), slice(300, 400))  # beyond the table's edge
TABLE = (slice(130, 350), slice(300, 540))  # nothing but the table, in the workspace
FIRST = "/camera/color/image_raw"
FRAMES = 1_000_000_000 + 200_000_000 * np.arange(2)


@cache
def face(height: int, width: int) -> NDArray[np.uint8]:
    """A portrait in the public domain that matplotlib ships (Rear Admiral Grace Hopper), RGB."""
    path = Path(matplotlib.get_data_path()) / "sample_data" / "grace_hopper.jpg"
    picture = cv2.imread(str(path))[60:430, 90:400, ::-1]
    return np.asarray(cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA))


@cache
def scene() -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    """RGB and depth [m]: a table with print, a head over it, upside down, and somebody beyond its edge."""
    color = np.random.default_rng(1).integers(150, 200, (HEIGHT, WIDTH, 3), np.uint8)
    depth = np.full((HEIGHT, WIDTH), 0.95, np.float32)
    depth[:110] = 1.6
    color[HEAD] = face(160, 140)[::-1, ::-1]
    depth[HEAD] = 0.6
    color[LOOKER_ON] = face(110, 100)
    return color, depth


def stamped(message: Any, stamp: int, frame: str = "camera") -> Any:
    message.header.frame_id = frame
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(int(stamp), 10**9)
    return message


def image(pixels: NDArray[Any], encoding: str, stamp: int, frame: str = "camera", padding: int = 0) -> Image:
    rows = np.ascontiguousarray(pixels).view(np.uint8).reshape(len(pixels), -1)
    data = np.pad(rows, ((0, 0), (0, padding)), constant_values=7)
    shape = {"height": pixels.shape[0], "width": pixels.shape[1], "step": data.shape[1], "encoding": encoding}
    return stamped(Image(data=array("B", data.tobytes()), **shape), stamp, frame)


def compressed(pixels: NDArray[Any], form: str, ending: str, stamp: int, header: bytes = b"") -> CompressedImage:
    data = array("B", header + cv2.imencode(ending, pixels)[1].tobytes())
    return stamped(CompressedImage(format=form, data=data), stamp)


@cache
def records(frame: str) -> bytes:
    """The scene's points, x, y, z [m] and packed rgb each."""
    color, depth = scene()
    columns, rows = CAMERA.rays()
    points = np.stack([columns * depth, rows * depth, depth], axis=-1)
    if frame != "camera":
        points = VOLUME.pose.to_base(points.reshape(-1, 3)).reshape(points.shape)
    kept = np.zeros((HEIGHT, WIDTH, 4), np.float32)
    kept[..., :3] = points
    kept[..., 3] = (color.astype(np.uint32) @ np.array([1 << 16, 1 << 8, 1], np.uint32)).view(np.float32)
    return kept.tobytes()


def cloud(stamp: int, frame: str = "camera", organized: bool = True) -> PointCloud2:
    fields = [PointField(name=n, offset=4 * k, datatype=7, count=1) for k, n in enumerate(("x", "y", "z", "rgb"))]
    height, width = (HEIGHT, WIDTH) if organized else (1, HEIGHT * WIDTH)
    made = PointCloud2(height=height, width=width, fields=fields, point_step=16, row_step=16 * width)
    made.data = array("B", records(frame))
    return stamped(made, stamp, frame)


def yuyv(color: NDArray[np.uint8]) -> NDArray[np.uint8]:
    yuv = cv2.cvtColor(color, cv2.COLOR_RGB2YUV)
    packed = yuv[..., :2].copy()
    packed[:, 1::2, 1] = yuv[:, ::2, 2]
    return packed


def pictures(stamp: int) -> dict[str, Any]:
    """One of each kind, by topic."""
    color, depth = scene()
    millimetres = np.round(1000 * depth).astype(np.uint16)
    return {
        "/camera/color/image_raw": image(color, "rgb8", stamp, padding=8),
        "/camera/color/image_raw/compressed": compressed(color[..., ::-1], "rgb8; jpeg compressed bgr8", ".jpg", stamp),
        "/camera/color/png": compressed(color[..., ::-1], "png", ".png", stamp),
        "/camera/grey": image(color[..., 1], "mono8", stamp),
        "/camera/yuyv": image(yuyv(color), "yuv422_yuy2", stamp),
        "/camera/depth/image_raw": image(millimetres, "16UC1", stamp),
        "/camera/depth/metres": image(depth, "32FC1", stamp),
        "/camera/depth/image_raw/compressedDepth": compressed(
            millimetres, "16UC1; compressedDepth png", ".png", stamp, bytes(12)
        ),
        "/camera/points": cloud(stamp),
        "/points_in_base": cloud(stamp, "base_link", organized=False),
    }


def written(folder: Path, messages: list[tuple[str, Any]], parameters: dict[str, Any] = PARAMETERS) -> Bag:
    info = CameraInfo(height=HEIGHT, width=WIDTH, k=[540.0, 0.0, 319.5, 0.0, 540.0, 239.5, 0.0, 0.0, 1.0])
    with BagWriter(folder) as bag:
        bag.add_facts({"session": "p07_sorting", "participant": "p07", **parameter_facts("/perception", parameters)})
        writer = MessageWriter(bag)
        writer.write("/camera/color/camera_info", stamped(info, 1), 10**9)
        for number, (topic, message) in enumerate(messages):
            writer.write(topic, message, 10**9 + number)
    return Bag(folder)


def shared(bag: Bag, folder: Path, kept: SharedPictures = SharedPictures.TABLE) -> tuple[Bag, Omissions]:
    omitted = shared_copy(bag, folder, session="a01_01", participant="a01", pictures=kept)
    return Bag(folder), omitted


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> tuple[Bag, Bag, Omissions]:
    """A bag with pictures of every kind, its copy, and what the copy lacks."""
    folder = tmp_path_factory.mktemp("pictures")
    bag = written(folder / "bag", [(t, m) for stamp in FRAMES for t, m in pictures(stamp).items()])
    return bag, *shared(bag, folder / "copy")


def of(bag: Bag, topic: str) -> list[Any]:
    return [read_picture(m.data, m.msgtype) for m in bag.messages({topic})]


@pytest.mark.parametrize("topic", [t for t in pictures(0) if "depth" not in t and "points" not in t])
def test_no_face_is_found_in_a_shared_picture_and_the_table_stays(study: tuple[Bag, Bag, Omissions], topic: str):
    bag, copy, _ = study
    finder, (before, *_), after = FaceFinder(), of(bag, topic), of(copy, topic)
    assert len(finder.find(grey(before), VOLUME.face_pixels)) == 2
    assert len(after) == len(FRAMES)
    looked = grey(after[-1])
    assert finder.find(looked, VOLUME.face_pixels) == []
    table = np.abs(looked[TABLE].astype(int) - grey(before)[TABLE])
    assert table.max() <= (0 if "compressed" not in topic else 60)
    assert table.mean() < 6
    assert np.abs(looked[:100].astype(int) - GREY).max() <= 6  # beyond the table


def test_faces_are_counted_and_nothing_is_left_out(study: tuple[Bag, Bag, Omissions]):
    _, _, omitted = study
    assert omitted.topics == {}
    assert omitted.covered is not None
    # Of the two in each moment one lies outside of the volume: it is not looked at.
    assert (omitted.covered.faces, omitted.covered.with_faces) == (len(FRAMES), len(FRAMES))
    assert omitted.covered.pictures == len(FRAMES) * len(pictures(0))
    assert omitted.covered.by_direction == 0


@pytest.mark.parametrize("topic", [t for t in pictures(0) if "depth" in t])
def test_distances_outside_of_the_volume_and_of_a_face_are_gone(study: tuple[Bag, Bag, Omissions], topic: str):
    bag, copy, _ = study
    (before, *_), (after, *_) = of(bag, topic), of(copy, topic)
    left = metres(after)
    assert not left[:110].any()
    assert not left[200:260, 100:160].any()
    assert np.array_equal(left[TABLE], metres(before)[TABLE])


@pytest.mark.parametrize("topic", ["/camera/points", "/points_in_base"])
def test_points_outside_of_the_volume_and_of_a_face_are_gone(study: tuple[Bag, Bag, Omissions], topic: str):
    _, copy, _ = study
    message = next(m for _, m in copy.decoded({topic}))
    records = np.frombuffer(message.data, np.float32).reshape(-1, 4)
    points = records[:, :3].astype(np.float64)
    there = np.isfinite(points).all(axis=1)
    in_base = points[there] if topic == "/points_in_base" else VOLUME.pose.to_base(points[there])
    assert VOLUME.contains(in_base).all()
    assert 50_000 < there.sum() < 200_000
    assert (in_base[:, 2] < 0.3).mean() > 0.9  # the head is 0.35 m above the table
    assert not records[~there, 3].any()
    assert message.height * message.width * 16 == len(message.data)


def test_a_face_that_the_next_picture_hides_from_the_finder_is_covered_there_too(tmp_path: Path):
    _, depth = scene()
    blurred = cv2.GaussianBlur(scene()[0], (0, 0), 9)
    first, second = FRAMES[:2]
    messages = [
        ("/camera/depth/image_raw", image(depth, "32FC1", first)),
        ("/camera/depth/image_raw", image(depth, "32FC1", second)),
        ("/camera/color/image_raw", image(scene()[0], "rgb8", first)),
        ("/camera/color/image_raw", image(blurred, "rgb8", second)),
    ]
    assert FaceFinder().find(grey(of(written(tmp_path / "bag", messages), "/camera/color/image_raw")[1]), 80) == []
    copy, _ = shared(Bag(tmp_path / "bag"), tmp_path / "copy")
    later = grey(of(copy, "/camera/color/image_raw")[1])
    assert (later[200:260, 100:160] == GREY).all()


def test_without_distances_what_lies_beside_the_table_is_covered_and_said(tmp_path: Path):
    bag = written(tmp_path / "bag", [("/camera/color/image_raw", image(scene()[0], "rgb8", FRAMES[0]))])
    copy, omitted = shared(bag, tmp_path / "copy")
    (picture,) = of(copy, "/camera/color/image_raw")
    assert FaceFinder().find(grey(picture), VOLUME.face_pixels) == []
    assert (grey(picture)[:60] == GREY).all()
    assert omitted.covered is not None
    assert omitted.covered.by_direction == 1


@pytest.mark.parametrize(
    ("parameters", "why"),
    [
        ({}, "does not say where the camera stood"),
        (PARAMETERS | {"camera_pose": "table"}, "came from 'table'"),
        (PARAMETERS | {"workspace_x": [-100.0, 100.0]}, "tells no table from a room"),
    ],
)
def test_without_a_known_camera_no_picture_is_kept_and_it_is_said_why(
    tmp_path: Path, parameters: dict[str, Any], why: str
):
    bag = written(tmp_path / "bag", list(pictures(FRAMES[0]).items()), parameters)
    copy, omitted = shared(bag, tmp_path / "copy")
    assert {t.name for t in copy.topics if t.count} == {"/camera/color/camera_info"}
    assert set(omitted.topics) == set(pictures(0))
    assert all(why in reason for reason, _ in omitted.topics.values())


def test_pictures_that_cannot_be_covered_are_left_out_one_by_one(tmp_path: Path):
    color, depth = scene()
    bad = {
        "/other/image_raw": (image(color, "rgb8", FRAMES[0], frame="wall_camera"), "wall_camera"),
        "/small": (image(color[:240, :320], "rgb8", FRAMES[0]), "320x240"),
        "/strange": (image(color, "nv21", FRAMES[0]), "nv21"),
        "/webp": (stamped(CompressedImage(format="webp", data=b"RIFF"), FRAMES[0]), "decoded"),
        "/points": (cloud(FRAMES[0], "map"), "map"),
    }
    good = ("/camera/depth/image_raw", image(depth, "32FC1", FRAMES[0]))
    copy, omitted = shared(written(tmp_path / "bag", [good, *((t, m) for t, (m, _) in bad.items())]), tmp_path / "copy")
    for topic, (_, word) in bad.items():
        why, count = omitted.topics[topic]
        assert word in why
        assert count == 1
    assert {t.name for t in copy.topics if t.count} == {"/camera/color/camera_info", good[0]}


def test_whole_pictures_are_kept_byte_by_byte(tmp_path: Path):
    bag = written(tmp_path / "bag", list(pictures(FRAMES[0]).items()))
    copy, omitted = shared(bag, tmp_path / "copy", SharedPictures.WHOLE)
    assert [bytes(m.data) for m in copy.messages()] == [bytes(m.data) for m in bag.messages()]
    assert omitted.covered is None


@given(
    st.lists(st.floats(-1, 1), min_size=4, max_size=4).filter(lambda q: sum(v * v for v in q) > 0.1),
    st.floats(0.3, 1.5),
    st.integers(0, 2**32 - 1),
)
@settings(max_examples=40, deadline=None)
def test_a_pixel_with_depth_stays_when_its_point_is_in_the_volume_and_only_then(
    orientation: list[float], height: float, seed: int
):
    rng = np.random.default_rng(seed)
    camera = Intrinsics(30.0, 30.0, 19.5, 14.5, 40, 30)
    pose = pose_from_quaternion((0.45, 0.0, height), orientation)
    volume = TableVolume(camera, pose, WORKSPACE)
    depth = rng.uniform(0.2, 2.0, (30, 40)).astype(np.float32)
    columns, rows = camera.rays()
    points = np.stack([columns * depth, rows * depth, depth], axis=-1).reshape(-1, 3).astype(np.float64)
    inside = volume.contains(pose.to_base(points)).reshape(30, 40)
    seen = volume.seen(depth)
    # A point on the volume's face may fall to either side by rounding.
    assert (seen != inside).mean() < 0.002
    # What lies in its lower part is kept without distances, too.
    low = inside & (pose.to_base(points)[:, 2].reshape(30, 40) < 0.19)
    assert not (low & ~volume.seen_without_depth).any()


@pytest.mark.parametrize("angle", range(0, 360, 60))
def test_a_face_is_found_whichever_way_it_is_turned_in_the_picture(angle: int):
    portrait = face(200, 170)
    turn = cv2.getRotationMatrix2D((84.5, 99.5), angle, 1.0)
    turn[:, 2] += (235.0, 140.0)
    picture = cv2.warpAffine(portrait, turn, (WIDTH, HEIGHT), borderValue=(128, 128, 128))
    found = FaceFinder().find(np.ascontiguousarray(picture[..., 1]), 80)
    assert found
    eyes = turn @ np.array([84.0, 85.0, 1.0])  # between them
    assert all(b.left <= eyes[0] < b.right and b.top <= eyes[1] < b.bottom for b in found)


@given(st.sampled_from(sorted(pictures(0))), st.integers(0, 2**32 - 1), st.integers(1, 30))
@settings(max_examples=60, deadline=None)
def test_a_damaged_picture_is_left_out_with_a_reason_or_covered(topic: str, seed: int, count: int):
    rng = np.random.default_rng(seed)
    message, kind = serialized()[topic]
    damaged = bytearray(message[: rng.integers(1, len(message) + 1)] if seed % 2 else message)
    for place in rng.integers(0, min(len(damaged), 400), count):
        damaged[place] = rng.integers(256)
    keep = np.zeros((HEIGHT, WIDTH), bool)
    try:
        picture = read_picture(bytes(damaged), kind)
        metres(picture) if is_depth(picture) else grey(picture)
        after = read_picture(covered(picture, keep), kind)
    except BagError as error:
        assert str(error)
        return
    # What is covered everywhere shows nothing: one grey, or no distance.
    left = metres(after) if is_depth(after) else grey(after)
    assert not left.any() if is_depth(after) else np.ptp(left) <= 2


@cache
def serialized() -> dict[str, tuple[bytes, str]]:
    """CDR bytes and type of each picture, by topic; of clouds the camera's picture instead."""
    kept = {topic: message for topic, message in pictures(0).items() if not isinstance(message, PointCloud2)}
    kinds = {topic: f"sensor_msgs/msg/{type(message).__name__}" for topic, message in kept.items()}
    return {t: (serialize_message(kept.get(t, kept[FIRST])), kinds.get(t, kinds[FIRST])) for t in pictures(0)}
