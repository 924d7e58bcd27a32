"""Which plane is the table, however the camera is mounted and however noisy it is."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_model.camera.intrinsics import Intrinsics
from mbd_model.camera.pose import CameraPose, pose_above_plane
from mbd_perception.frames.frame import FrameError, RgbdFrame, make_frame
from mbd_perception.frames.units import height_doubt
from mbd_perception.segmentation.segment import SegmentationConfig, segment
from mbd_perception.segmentation.table.beside import TablesInView, tables_beside
from mbd_perception.segmentation.table.orientation import (
    quarter_turns,
    turned_camera,
    turned_frame,
    turned_normal,
)  # fmt: skip
from mbd_perception.segmentation.table.plane import NoTableError
from mbd_perception.synthetic.render import Box, Cylinder, Table, looking_at, render
from mbd_perception.synthetic.scoring import score
from mbd_perception.synthetic.sensors import Sensor

BLUE = (40, 40, 200)
SLANTED = looking_at((-0.1, 0.0, 0.7), (0.65, 0.0, 0.05))
SOLIDS: list[Box | Cylinder] = [
    Box((0.6, 0.12, 0.0), (0.08, 0.1, 0.1), (200, 40, 40), 0.3),
    Cylinder((0.7, -0.1, 0.0), 0.05, 0.12, (40, 40, 200)),
]


def frame_of(table: Table | None = None, noise: float = 2e-3) -> RgbdFrame:
    """A table with two things on it."""
    rng = np.random.default_rng(5)
    return render(SOLIDS, SLANTED, rng, table=table or Table(), sensor=Sensor(noise=noise)).frame


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_turned(turns: int) -> None:
    """Mounted on its side or upside down, a camera sees the same things, turned, without knowing its pose."""
    frame = frame_of()
    upright = segment(frame, None, SegmentationConfig())
    turned = segment(turned_frame(frame, turns), None, SegmentationConfig())
    assert turned.count == upright.count == 2
    np.testing.assert_array_equal(np.rot90(turned.labels, -turns) > 0, upright.labels > 0)
    np.testing.assert_allclose(turned.plane.normal, turned_normal(upright.plane.normal, turns), atol=0.01)


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_turned_with_a_wall_in_view(turns: int) -> None:
    """A wall is level for a camera mounted another way, and as large as a table; things stand on the table."""
    frame = frame_of(Table(floor_z=-0.72, wall_x=1.6))
    upright = segment(frame, None, SegmentationConfig())
    turned = segment(turned_frame(frame, turns), None, SegmentationConfig())
    assert turned.count == upright.count == 2
    assert turned.plane.offset == pytest.approx(0.7, abs=0.01)


def test_four_turns() -> None:
    """Four quarter turns change nothing, and a turn of the picture turns its rays."""
    camera = Intrinsics(500.0, 510.0, 310.0, 245.0, width=640, height=480)
    assert turned_camera(camera, 4) == camera
    ray = np.array([(100 - camera.cx) / camera.fx, (50 - camera.cy) / camera.fy, 1.0])
    turned = turned_camera(camera, 1)
    u, v = 50, camera.width - 1 - 100
    expected = np.array([(u - turned.cx) / turned.fx, (v - turned.cy) / turned.fy, 1.0])
    np.testing.assert_allclose(turned_normal(ray, 1), expected)


def test_straight_down() -> None:
    """Looking straight down nothing is turned."""
    assert quarter_turns(np.array([0.05, 0.1, -0.99])) == 0


def test_small_table() -> None:
    """A side table 35 cm square over a floor half a metre below is the table."""
    small = Table(x=(0.47, 0.82), y=(-0.175, 0.175), floor_z=-0.5)
    solids = [Box((0.58, 0.06, 0.0), (0.08, 0.1, 0.1), (200, 40, 40), 0.3)]
    frame = render(solids, SLANTED, np.random.default_rng(5), table=small, sensor=Sensor(noise=2e-3)).frame
    assert segment(frame, None, SegmentationConfig()).plane.offset == pytest.approx(0.7, abs=0.02)


BENCHES = looking_at((-0.3, 0.0, 0.9), (0.75, 0.0, 0.0))
LEFT = Table(x=(0.4, 1.1), y=(0.1, 0.7), floor_z=-0.72)
ON_LEFT: list[Box | Cylinder] = [
    Box((0.7, 0.25, 0.0), (0.08, 0.1, 0.1), (200, 40, 40)),
    Cylinder((0.8, 0.5, 0.0), 0.05, 0.12, (40, 40, 200)),
]


def two_tables(top: float, on_right: bool) -> tuple[RgbdFrame, TablesInView, int]:
    """A laden table to the left, and one to the right whose top is that high, laden or not: frame, tables, objects."""
    right = [Box((0.75, -0.4, -0.3), (0.7, 0.6, 0.3 + top), (190, 188, 185))]
    there = [Box((0.75, -0.4, top), (0.1, 0.1, 0.1), (40, 160, 60))] if on_right else []
    rng = np.random.default_rng(3)
    view = render(ON_LEFT + there, BENCHES, rng, table=LEFT, clutter=right, sensor=Sensor(noise=2e-3))
    found = segment(view.frame, None, SegmentationConfig())
    pose = pose_above_plane(found.plane.normal, found.plane.offset)
    return view.frame, tables_beside(view.frame, found.plane, found.noise, pose), found.count


@pytest.mark.parametrize("on_right", [False, True])
def test_two_tables(on_right: bool) -> None:
    """Of two tables side by side and equally high, what stands on either is seen, and that there are two is said."""
    _, tables, count = two_tables(0.0, on_right)
    assert count == 2 + on_right
    (other,) = tables.others
    assert other.level
    assert other.area == pytest.approx(0.4, abs=0.1)
    assert "another table is in view (to the " in tables.hint
    assert "at the same height" in tables.hint


@pytest.mark.parametrize(("top", "words"), [(0.12, r"0\.1\d m higher"), (-0.2, r"0\.(19|20|21) m lower")])
def test_other_height(top: float, words: str) -> None:
    """A second table higher or lower is said, on its side and with its height; the laden one is the table."""
    _, tables, count = two_tables(top, on_right=False)
    assert count == 2
    (other,) = tables.others
    assert other.higher == pytest.approx(top, abs=0.015)
    assert re.search(f"to the right, {words}", tables.hint)


@pytest.mark.parametrize("floor", [None, -0.72])
def test_one_table(floor: float | None) -> None:
    """Neither the floor nor a large box on the table is another table."""
    solids = [*ON_LEFT, Box((0.75, -0.3, 0.0), (0.3, 0.3, 0.2), (30, 40, 200))]
    table = Table(x=(0.35, 1.3), y=(-0.75, 0.75), floor_z=floor)
    frame = render(solids, BENCHES, np.random.default_rng(3), table=table, sensor=Sensor(noise=2e-3)).frame
    found = segment(frame, None, SegmentationConfig())
    pose = pose_above_plane(found.plane.normal, found.plane.offset)
    assert found.count == 3
    assert tables_beside(frame, found.plane, found.noise, pose).hint == ""


def test_shadow() -> None:
    """A band without depth across the table makes no second table of it, and what stands beyond is seen."""
    frame, _, _ = two_tables(0.0, on_right=True)
    solids = [*ON_LEFT, Box((0.75, -0.4, 0.0), (0.1, 0.1, 0.1), (40, 160, 60))]
    one = Table(x=(0.4, 1.1), y=(-0.7, 0.7), floor_z=-0.72)
    frame = render(solids, BENCHES, np.random.default_rng(3), table=one, sensor=Sensor(noise=2e-3)).frame
    depth = frame.depth.copy()
    depth[:, 330:350] = 0
    shaded = make_frame(frame.color, depth, frame.camera)
    found = segment(shaded, None, SegmentationConfig())
    pose = pose_above_plane(found.plane.normal, found.plane.offset)
    assert found.count == 3
    assert tables_beside(shaded, found.plane, found.noise, pose).others == ()


@pytest.mark.parametrize("shape", ["side table", "bench below", "shelf above", "round"])
@pytest.mark.parametrize("known", [False, True])
def test_kinds_of_table(shape: str, known: bool) -> None:
    """A side table of 30 cm, a bench 25 cm below, a shelf above, a round table: found, pose known or not."""
    clutter: list[Box | Cylinder] = []
    table = Table(x=(0.45, 1.0), y=(-0.4, 0.4), floor_z=-0.72)
    solids = [Box((0.6, 0.08, 0.0), (0.06, 0.07, 0.1), (200, 40, 40), 0.3), Cylinder((0.62, -0.08, 0), 0.03, 0.1, BLUE)]
    if shape == "side table":
        table = Table(x=(0.47, 0.77), y=(-0.15, 0.15), floor_z=-0.5)
    elif shape == "bench below":
        clutter = [Box((1.5, 0.0, -0.3), (0.9, 2.0, 0.05), (190, 188, 185))]
    elif shape == "shelf above":
        clutter = [Box((1.3, 0.0, 0.25), (0.3, 1.2, 0.03), (150, 110, 70))]
    else:
        table = Table(x=(5.0, 5.1), y=(5.0, 5.1), floor_z=-0.5)
        clutter = [Cylinder((0.65, 0.0, -0.03), 0.3, 0.03, (190, 188, 185))]
    view = render(solids, SLANTED, np.random.default_rng(6), table=table, clutter=clutter, sensor=Sensor(noise=2e-3))
    found = segment(view.frame, view.pose if known else None, SegmentationConfig())
    assert found.plane.offset == pytest.approx(0.7, abs=0.02)
    result = score(found.labels, np.where(view.labels > 1, view.labels, 0), view.frame.depth > 0)
    assert (result.found, result.false_objects) == (2, 0)


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_turned_with_pose(turns: int) -> None:
    """Mounted on its side or upside down, with its pose known, a camera sees the same things."""
    frame = frame_of()
    turn = np.stack([turned_normal(axis, turns) for axis in np.eye(3)], axis=1)  # old optical frame to the new one
    pose = CameraPose(SLANTED.rotation @ turn.T, SLANTED.position)
    upright = segment(frame, SLANTED, SegmentationConfig())
    turned = segment(turned_frame(frame, turns), pose, SegmentationConfig())
    assert turned.count == upright.count == 2
    np.testing.assert_array_equal(np.rot90(turned.labels, -turns) > 0, upright.labels > 0)


@pytest.mark.parametrize("wall", [1.0, 1.3, 1.8])
@pytest.mark.parametrize("side", [False, True])
def test_walls(wall: float, side: bool) -> None:
    """Behind the table or beside it, an uncropped wall with a picture on it is no object."""
    clutter = [Box((wall - 0.02, 0.1, 0.3), (0.02, 0.3, 0.25), (120, 80, 50))]
    if side:
        clutter.append(Box((0.7, 0.75, -0.7), (3.0, 0.02, 2.5), (220, 220, 210)))
    table = Table(x=(0.3, 0.98), y=(-0.7, 0.7), floor_z=-0.72, wall_x=wall)
    view = render(SOLIDS, SLANTED, np.random.default_rng(7), table=table, clutter=clutter, sensor=Sensor(noise=2e-3))
    found = segment(view.frame, None, SegmentationConfig())
    result = score(found.labels, np.where(view.labels > 1, view.labels, 0), view.frame.depth > 0)
    assert (result.found, result.false_objects) == (2, 0)


def test_six_millimetres() -> None:
    """Noise of 6 mm at 0.9 m is measured and used: both things are seen, nothing else, and the noise is stated."""
    view = render(SOLIDS, looking_at((-0.1, 0.0, 0.62), (0.65, 0.0, 0.05)), np.random.default_rng(5), table=Table(),
                  sensor=Sensor(noise=6e-3 / 0.9**2))  # fmt: skip
    found = segment(view.frame, None, SegmentationConfig())
    result = score(found.labels, np.where(view.labels > 1, view.labels, 0), view.frame.depth > 0)
    assert (result.found, result.false_objects) == (2, 0)
    assert found.noise * 0.9**2 == pytest.approx(6e-3, rel=0.15)


def test_noisy() -> None:
    """A camera four times as noisy as expected still sees both things, and its noise is measured."""
    found = segment(frame_of(noise=6e-3), None, SegmentationConfig())
    assert found.count == 2
    assert found.noise == pytest.approx(6e-3, rel=0.15)


@pytest.mark.parametrize("factor", [5.0, 10.0, 20.0, 1000.0])
def test_wrong_units(factor: float) -> None:
    """Depth in other units ends in an answer: a scene, or a reason that names the units."""
    frame = frame_of()
    try:
        made = make_frame(frame.color, frame.depth * np.float32(factor), frame.camera)
        segment(made, None, SegmentationConfig())
    except (NoTableError, FrameError) as error:
        assert "table" in str(error) or "metres" in str(error)
    else:
        assert factor <= 10.0


@pytest.mark.parametrize(("height", "factor"), [(0.4, 5.0), (0.6, 5.0), (0.55, 0.2), (1.2, 0.1), (0.9, 10.0)])
def test_a_pose_that_contradicts_the_table(height: float, factor: float) -> None:
    """A table found at 5, 10, 0.2 or 0.1 times the height of the known pose is answered with a hint at the units."""
    assert "depth units" in height_doubt(factor * height, height)


@given(height=st.floats(0.2, 2.5), tilt=st.floats(0.5, 2.0))
def test_a_plausible_height_is_no_contradiction(height: float, tilt: float) -> None:
    """A base that stands lower or higher than the table is no other unit."""
    assert height_doubt(height, height / tilt) == ""
