"""Which plane is the table, however the camera is mounted and however noisy it is."""

from __future__ import annotations

import numpy as np
import pytest
from mbd_model.camera.intrinsics import Intrinsics
from mbd_perception.frames.frame import FrameError, RgbdFrame, make_frame
from mbd_perception.segmentation.segment import SegmentationConfig, segment
from mbd_perception.segmentation.table.orientation import (
    quarter_turns,
    turned_camera,
    turned_frame,
    turned_normal,
)  # fmt: skip
from mbd_perception.segmentation.table.plane import NoTableError
from mbd_perception.synthetic.render import Box, Cylinder, Table, looking_at, render
from mbd_perception.synthetic.sensors import Sensor

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
