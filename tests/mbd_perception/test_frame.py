"""Frames are checked where they enter, and fused by their median."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from mbd_model.camera.intrinsics import CameraError, Intrinsics
from mbd_perception.frames.frame import FrameError, RgbdFrame, fuse, make_frame

CAMERA = Intrinsics(fx=20.0, fy=20.0, cx=3.5, cy=2.5, width=8, height=6)
COLOR = np.zeros((6, 8, 3), dtype=np.uint8)


def frame_of(depth: np.ndarray, stamp: float = 0.0) -> RgbdFrame:
    """A black frame of that depth [m]."""
    return make_frame(COLOR, depth, CAMERA, stamp)


@given(hnp.arrays(np.float32, (6, 8), elements=st.floats(width=32)))
def test_depth_is_clean(depth: np.ndarray) -> None:
    """Whatever floats come in, the depth of a frame is finite and not negative, or the frame is refused."""
    try:
        clean = frame_of(depth).depth
    except FrameError as error:
        assert "no pixel of the depth image has a value" in str(error) or "publish metres" in str(error)
    else:
        assert np.isfinite(clean).all()
        assert (clean >= 0).all()


def test_millimetres() -> None:
    """Unsigned integers are millimetres."""
    assert frame_of(np.full((6, 8), 1234, dtype=np.uint16)).depth[0, 0] == pytest.approx(1.234)


@pytest.mark.parametrize(
    ("color", "depth", "words"),
    [
        (COLOR, np.zeros((0, 0), dtype=np.uint16), "not a .height, width. picture"),
        (COLOR, np.ones((5, 8), dtype=np.uint16), "registered to colour"),
        (COLOR[..., 0], np.ones((6, 8), dtype=np.uint16), "RGB"),
        (COLOR.astype(np.float32), np.ones((6, 8), dtype=np.uint16), "uint8"),
        (COLOR, np.ones((6, 8), dtype=np.int8), "neither uint16"),
        (COLOR, np.zeros((6, 8), dtype=np.uint16), "all zero or NaN"),
        (np.zeros((3, 4, 3), dtype=np.uint8), np.ones((3, 4), dtype=np.uint16), "camera_info states 8x6"),
    ],
)
def test_refused(color: np.ndarray, depth: np.ndarray, words: str) -> None:
    """Images that do not fit are refused with what was wrong."""
    with pytest.raises(FrameError, match=words):
        make_frame(color, depth, CAMERA)


def test_uncalibrated_camera() -> None:
    """A camera_info of zeros is no camera."""
    with pytest.raises(CameraError, match="focal lengths"):
        Intrinsics(fx=0.0, fy=0.0, cx=0.0, cy=0.0, width=8, height=6)


@settings(max_examples=50)
@given(st.permutations(range(5)))
def test_median(order: list[int]) -> None:
    """The fused depth is the median, in whatever order the frames came."""
    depths = [np.full((6, 8), z, dtype=np.float32) for z in (1.0, 1.1, 1.2, 5.0, 0.2)]
    assert fuse([frame_of(depths[i]) for i in order]).depth[0, 0] == pytest.approx(1.1)


def test_holes_close() -> None:
    """A hole in a minority of frames closes; depth in a minority of frames is not believed."""
    complete = np.ones((6, 8), dtype=np.float32)
    holed = complete.copy()
    holed[2, 3] = 0
    assert fuse([frame_of(complete), frame_of(holed), frame_of(complete)]).depth[2, 3] == 1
    assert fuse([frame_of(holed), frame_of(holed), frame_of(complete)]).depth[2, 3] == 0


def test_stamp_of_last() -> None:
    """The fused frame has the stamp of the last."""
    depth = np.ones((6, 8), dtype=np.float32)
    assert fuse([frame_of(depth, 1.0), frame_of(depth, 2.0)]).stamp == 2.0
    with pytest.raises(FrameError, match="no frame"):
        fuse([])
