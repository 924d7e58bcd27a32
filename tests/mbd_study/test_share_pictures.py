"""Of shared pictures only what lies in the table's volume stays, and no face that can be found."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_bag.errors import BagError
from mbd_bag.storage.bag import Bag
from mbd_model.camera.intrinsics import Intrinsics
from mbd_model.camera.pose import pose_from_quaternion
from mbd_study.sharing.pictures.encodings import GREY, covered, grey, is_depth, metres, read_picture
from mbd_study.sharing.pictures.faces import FaceFinder
from mbd_study.sharing.pictures.volume import TableVolume
from mbd_study.sharing.rules import SharedPictures
from mbd_study.sharing.shared_copy import Omissions
from rclpy.serialization import serialize_message
from sensor_msgs.msg import CompressedImage, PointCloud2

from tests.mbd_study.picture_bags import (
    FIRST,
    FRAMES,
    HEIGHT,
    PARAMETERS,
    TABLE,
    VOLUME,
    WIDTH,
    WORKSPACE,
    cloud,
    face,
    image,
    pictures,
    scene,
    shared,
    stamped,
    written,
)


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
