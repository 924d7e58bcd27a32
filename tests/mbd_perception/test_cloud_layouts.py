"""Organized clouds of any memory layout give the same frame."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mbd_model.camera.intrinsics import Intrinsics
from mbd_perception.frames.clouds import CloudBytes, CloudField, frame_from_cloud
from mbd_perception.frames.frame import FrameError

WIDTH, HEIGHT = 24, 18
CAMERA = Intrinsics(fx=30.0, fy=31.0, cx=11.0, cy=9.0, width=WIDTH, height=HEIGHT)
FLOAT32, UINT32, UINT8, FLOAT64 = 7, 6, 2, 8


def surface() -> tuple[np.ndarray, np.ndarray]:
    """(depth, colour) of a small bumpy surface with a hole."""
    rng = np.random.default_rng(0)
    depth = rng.uniform(0.8, 1.2, (HEIGHT, WIDTH)).astype(np.float32)
    depth[4, 5] = np.nan
    return depth, rng.integers(0, 256, (HEIGHT, WIDTH, 3)).astype(np.uint8)


@st.composite
def layouts(draw: st.DrawFn) -> CloudBytes:
    """That surface as a cloud in some layout."""
    depth, color = surface()
    columns, rows = CAMERA.rays()
    big = draw(st.booleans())
    end = ">" if big else "<"
    axis = draw(st.sampled_from((("f4", FLOAT32), ("f8", FLOAT64))))
    packed = (color[..., 0].astype(np.uint32) << 16) | (color[..., 1].astype(np.uint32) << 8) | color[..., 2]
    values = {
        "x": ((columns * depth), *axis),
        "y": ((rows * depth), *axis),
        "z": (depth, *axis),
    }
    kind = draw(st.sampled_from(("rgb", "rgba", "separate", "first")))
    if kind == "separate":
        values |= {name: (color[..., i], "u1", UINT8) for i, name in enumerate("rgb")}
    else:
        values["rgb" if kind == "first" else kind] = (packed, "u4", FLOAT32 if kind == "rgb" else UINT32)
    offset, dtype_names, offsets, formats, fields = 0, [], [], [], []
    for name in draw(st.permutations(sorted(values))):
        _, form, code = values[name]
        offset += draw(st.integers(0, 5))
        fields.append(CloudField(name, offset, code))
        dtype_names.append(name)
        offsets.append(offset)
        formats.append(end + form)
        offset += np.dtype(form).itemsize
    step = offset + draw(st.integers(0, 7))
    row_step = step * WIDTH + draw(st.integers(0, 9))
    record = np.dtype({"names": dtype_names, "formats": formats, "offsets": offsets, "itemsize": step})
    points = np.zeros((HEIGHT, WIDTH), dtype=record)
    for name in dtype_names:
        points[name] = values[name][0]
    data = b"".join(points[r].tobytes() + bytes(row_step - step * WIDTH) for r in range(HEIGHT))
    return CloudBytes(WIDTH, HEIGHT, fields, step, row_step, data, big)


@settings(max_examples=60)
@given(layouts())
def test_any_layout(cloud: CloudBytes) -> None:
    """Field order, offsets, padding, byte order and number types do not matter."""
    frame = frame_from_cloud(cloud, 3.0)
    depth, color = surface()
    assert np.allclose(frame.depth, np.nan_to_num(depth), atol=1e-6)
    assert np.array_equal(frame.color, color)
    assert frame.camera.fx == pytest.approx(CAMERA.fx, rel=1e-3)
    assert frame.camera.cy == pytest.approx(CAMERA.cy, abs=0.01)
    assert frame.stamp == 3.0


@settings(max_examples=60)
@given(layouts(), st.data())
def test_truncated(cloud: CloudBytes, data: st.DataObject) -> None:
    """A cloud cut off anywhere is refused, and reports it."""
    left = data.draw(st.integers(0, HEIGHT * cloud.row_step // 2))
    cut = CloudBytes(
        cloud.width, cloud.height, cloud.fields, cloud.point_step, cloud.row_step, cloud.data[:left], cloud.bigendian
    )
    with pytest.raises(FrameError, match=r"cut off|empty"):
        frame_from_cloud(cut)


def plain(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> CloudBytes:
    """A cloud of x, y, z alone."""
    fields = [CloudField(name, 4 * i, FLOAT32) for i, name in enumerate("xyz")]
    data = np.stack([x, y, z], axis=-1).astype("<f4").tobytes()
    height, width = x.shape
    return CloudBytes(width, height, fields, 12, 12 * width, data)


def test_all_nan() -> None:
    """A cloud of NaN or infinity has no valid point."""
    for bad in (np.nan, np.inf, -np.inf, 0.0):
        empty = np.full((HEIGHT, WIDTH), bad, dtype=np.float32)
        with pytest.raises(FrameError, match="none of the 432 points"):
            frame_from_cloud(plain(empty, empty, empty))


def test_unorganized() -> None:
    """A cloud of one row is refused, with what to turn on."""
    ones = np.ones((1, 50), dtype=np.float32)
    with pytest.raises(FrameError, match="not organized"):
        frame_from_cloud(plain(ones, ones, ones))


def test_base_frame() -> None:
    """A cloud that is not in the optical frame is recognised by its rays."""
    depth, _ = surface()
    columns, rows = CAMERA.rays()
    with pytest.raises(FrameError, match="optical frame"):
        frame_from_cloud(plain(depth, -columns * depth, -rows * depth + 2.0))


def test_no_color() -> None:
    """A cloud without colour is grey, so that nothing gets a hue from it."""
    depth, _ = surface()
    columns, rows = CAMERA.rays()
    assert (frame_from_cloud(plain(columns * depth, rows * depth, depth)).color == 128).all()


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_random_bytes(seed: int) -> None:
    """Bytes that are no cloud at all are refused with a reason."""
    data = np.random.default_rng(seed).bytes(16 * 30 * 20)
    fields = [CloudField(name, 4 * i, 7) for i, name in enumerate(("x", "y", "z", "rgb"))]
    with pytest.raises(FrameError, match="rays of its pixels"):
        frame_from_cloud(CloudBytes(30, 20, fields, 16, 480, data))
