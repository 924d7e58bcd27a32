"""The picture shows both scenes and the mapping, with or without a camera."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_bag.errors import BagError
from mbd_bag.ros.session_conversions import session_from_bag, session_to_bag
from mbd_bag.session.scene_images import camera_of, image_at
from mbd_bag.storage.bag import Bag
from mbd_bag.storage.bag_writer import BagWriter
from mbd_model.objects import SceneObject
from mbd_study.figures import pictures
from mbd_study.figures.mapping_figure import ASSISTED, PREDICTED, WRONG, box_corners
from mbd_study.figures.pictures import arrows_of, draw_session, panels_of
from mbd_study.synthetic import CAMERA, CAMERA_POSITION, SyntheticSession

metres = st.floats(-0.3, 0.3)


@given(x=metres, y=metres, z=st.floats(0.0, 0.3))
def test_a_camera_straight_above_sees_away_from_the_robot_up_and_left_left(x: float, y: float, z: float):
    point = np.array([CAMERA_POSITION[0] + x, y, z])
    ((u, v),) = CAMERA.project(point[None])
    scale = 540.0 / (CAMERA_POSITION[2] - z)
    assert (u, v) == pytest.approx((319.5 - scale * y, 239.5 - scale * x), abs=1e-6)


def test_what_is_behind_the_camera_is_nowhere():
    assert np.isnan(CAMERA.project(np.array([[0.45, 0.0, 2.0]]))).all()


@given(width=st.floats(0.01, 0.3), depth=st.floats(0.01, 0.3), yaw=st.floats(-4.0, 4.0))
def test_a_box_keeps_its_sides_and_middle_however_it_is_turned(width: float, depth: float, yaw: float):
    both = box_corners(SceneObject("a", (0.4, 0.1, 0.05), (width, depth, 0.1), yaw))
    assert both.mean(axis=0) == pytest.approx([0.4, 0.1, 0.05])
    assert set(both[:, 2].round(9)) == {0.0, 0.1}
    corners = both[:4]
    sides = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    assert sides == pytest.approx([width, depth, width, depth])
    along = corners[0] - corners[3]  # the depth runs along x at yaw 0
    assert abs(along[0] * np.sin(yaw) - along[1] * np.cos(yaw)) < 1e-9


def test_the_bag_gives_the_camera_and_the_picture_of_each_observation(made: SyntheticSession, made_bag: Path):
    bag = Bag(made_bag)
    camera = camera_of(bag)
    assert camera is not None
    assert camera.intrinsics == CAMERA.intrinsics
    assert np.allclose(camera.pose.rotation, CAMERA.pose.rotation)
    for scene, shown in zip(
        (made.recorded.source_scenes[0], made.recorded.target_scenes[0]), made.pictures, strict=True
    ):
        found = image_at(bag, scene.stamp, scene.log_time)
        assert found is not None
        assert np.array_equal(found, shown.value)


def test_the_arrows_are_the_last_mapping_in_three_colours(made: SyntheticSession):
    arrows = arrows_of(made.recorded)
    assert {(a.source_id, a.target_id) for a in arrows} == set(made.recorded.estimates[-1][0].value.mapping.pairs)
    assisted = {(a.source_id, a.target_id) for a in made.recorded.assists[-1].value}
    assert {(a.source_id, a.target_id) for a in arrows if a.color == ASSISTED} == assisted
    early = arrows_of(replace(made.recorded, estimates=made.recorded.estimates[:1]))
    right = {a for a in early if a.target_id in made.solution[a.source_id]}
    assert all(a.color == (PREDICTED if a in right else WRONG) for a in early)


def test_the_tool_draws_the_boxes_over_the_picture(
    made_bag: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    out = tmp_path / "new" / "mapping.png"
    monkeypatch.setattr(sys, "argv", ["picture", str(made_bag), "--out", str(out)])
    with pytest.raises(SystemExit) as ended:
        pictures.main()
    assert ended.value.code == 0
    assert str(out) in "".join(capsys.readouterr().out.split("\n"))
    image = cv2.imread(str(out))
    assert image.shape[1] > 1200
    table = np.array([140, 168, 188])  # of the synthetic picture, BGR
    assert (np.abs(image.astype(int) - table).max(axis=2) < 3).mean() > 0.2


def test_without_a_picture_the_scenes_are_drawn_from_above(made: SyntheticSession, tmp_path: Path):
    with BagWriter(tmp_path / "bag") as writer:
        session_to_bag(made.recorded, writer)
    bag = Bag(tmp_path / "bag")
    recorded = session_from_bag(bag)
    assert all(panel.camera is None and panel.image is None for panel in panels_of(bag, recorded))
    draw_session(bag, recorded, tmp_path / "above.png")
    assert cv2.imread(str(tmp_path / "above.png")) is not None


def test_a_scene_in_a_frame_of_its_own_is_not_drawn_over_the_picture(made: SyntheticSession, made_bag: Path):
    bag = Bag(made_bag)
    bag.facts["parameter./perception.camera_pose"] = "table"
    assert camera_of(bag) is None


def test_a_session_that_never_saw_its_target_has_no_picture(made: SyntheticSession, made_bag: Path, tmp_path: Path):
    with pytest.raises(BagError, match="no target scene"):
        draw_session(Bag(made_bag), replace(made.recorded, target_scenes=()), tmp_path / "x.png")
