"""Compressed colour and depth come out as what was compressed, and what is damaged is refused in words."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from compressing import png, quantised, rvl, with_header
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from mbd_perception.frames.compressed_images import decode_color, decode_depth
from mbd_perception.frames.frame import FrameError
from mbd_perception.frames.rvl import decode_rvl

SHAPES = hnp.array_shapes(min_dims=2, max_dims=2, max_side=12)
DEPTHS = hnp.arrays(np.uint16, SHAPES, elements=st.one_of(st.just(0), st.integers(0, 65535)))
COLOR = np.zeros((24, 32, 3), np.uint8)
COLOR[:, :16], COLOR[:, 16:] = (200, 60, 30), (20, 120, 220)


@given(DEPTHS)
def test_rvl(depth: np.ndarray) -> None:
    """RVL loses nothing, whatever values stand beside each other."""
    np.testing.assert_array_equal(decode_rvl(rvl(depth)), depth)


def test_rvl_by_hand() -> None:
    """Two pixels without depth, then 5 and 3: the nibbles 2, 2, then +5 as 10 = 2 + 8 * 1, -2 as 3."""
    word = 0x22A13000
    data = np.array([4, 1, word], dtype="<u4").tobytes()
    np.testing.assert_array_equal(decode_rvl(data), [[0, 0, 5, 3]])


@settings(max_examples=100)
@given(DEPTHS, st.data())
def test_damaged_rvl(depth: np.ndarray, data: st.DataObject) -> None:
    """Cut off or altered, RVL gives a picture or a reason."""
    whole = bytearray(rvl(depth))
    for place in data.draw(st.lists(st.integers(0, len(whole) - 1), max_size=3)):
        whole[place] = data.draw(st.integers(0, 255))
    part = bytes(whole[: data.draw(st.integers(0, len(whole)))])
    try:
        assert decode_rvl(part).dtype == np.uint16
    except FrameError as error:
        assert "RVL" in str(error)


@given(DEPTHS, st.sampled_from(("png", "rvl", "")))
def test_millimetres(depth: np.ndarray, code: str) -> None:
    """16UC1 comes back as it was, by either code, and by the name of older publishers that state none."""
    body = rvl(depth) if code == "rvl" else png(depth)
    form = f"16UC1; compressedDepth {code}".strip()
    np.testing.assert_array_equal(decode_depth(with_header(body), form), depth)


def test_png_alone() -> None:
    """Depth on a topic /compressed is a PNG without a header."""
    depth = np.arange(12, dtype=np.uint16).reshape(3, 4) * 5000
    np.testing.assert_array_equal(decode_depth(png(depth), "16UC1; png compressed "), depth)


@pytest.mark.parametrize("code", ["png", "rvl"])
def test_metres(code: str) -> None:
    """32FC1 comes back as inverse depth of 16 bits holds it: within half a millimetre at 2 m; none stays none."""
    metres = np.linspace(0.3, 2.0, 60, dtype=np.float32).reshape(6, 10)
    metres[2, 3] = np.nan
    values, scale, shift = quantised(metres)
    body = png(values) if code == "png" else rvl(values)
    depth = decode_depth(with_header(body, scale, shift), f"32FC1; compressedDepth {code}")
    assert np.isnan(depth[2, 3])
    np.testing.assert_allclose(depth, metres, atol=5e-4)


@pytest.mark.parametrize(
    ("form", "picture", "suffix"),
    [
        ("rgb8; jpeg compressed bgr8", COLOR[..., ::-1], ".jpg"),
        ("bgr8; jpeg compressed bgr8", COLOR[..., ::-1], ".jpg"),
        ("rgb8; png compressed bgr8", COLOR[..., ::-1], ".png"),
        ("rgb8; png compressed rgb8", COLOR, ".png"),
        ("bgra8; png compressed bgra8", np.dstack([COLOR[..., ::-1], np.full((24, 32), 9, np.uint8)]), ".png"),
        ("rgb16; png compressed bgr16", COLOR[..., ::-1].astype(np.uint16) << 8, ".png"),
        ("jpeg", COLOR[..., ::-1], ".jpg"),
        ("", COLOR[..., ::-1], ".png"),
    ],
)
def test_color(form: str, picture: np.ndarray, suffix: str) -> None:
    """Red is red again, whichever order the file has it in."""
    data = cv2.imencode(suffix, picture)[1].tobytes()
    np.testing.assert_allclose(decode_color(data, form)[:, [2, 29]].astype(int), COLOR[:, [2, 29]].astype(int), atol=6)


def test_grey() -> None:
    """One channel becomes three equal ones."""
    grey = COLOR[..., 0]
    np.testing.assert_array_equal(decode_color(png(grey), "mono8; png compressed "), np.dstack([grey] * 3))


@pytest.mark.parametrize(
    ("data", "form", "words"),
    [
        (b"", "rgb8; jpeg compressed bgr8", "cannot be decoded"),
        (b"no picture", "jpeg", "cannot be decoded"),
        (png(COLOR.astype(np.float32))[:40], "png", "cannot be decoded"),
    ],
)
def test_no_color(data: bytes, form: str, words: str) -> None:
    """What is no picture is refused."""
    with pytest.raises(FrameError, match=words):
        decode_color(data, form)


@pytest.mark.parametrize(
    ("data", "form", "words"),
    [
        (b"", "16UC1; compressedDepth png", "header takes 12"),
        (with_header(b"no picture"), "16UC1; compressedDepth png", "cannot be decoded"),
        (with_header(b""), "16UC1; compressedDepth rvl", "header takes 12"),
        (with_header(b"1234"), "16UC1; compressedDepth rvl", "cut off"),
        (with_header(np.array([2**31, 2**31], "<u4").tobytes()), "16UC1; compressedDepth rvl", "damaged"),
        (cv2.imencode(".jpg", COLOR)[1].tobytes(), "jpeg", "JPEG keeps no depth"),
        (with_header(png(np.ones((2, 2), np.uint16)), np.nan), "32FC1; compressedDepth png", "quantisation"),
    ],
)
def test_no_depth(data: bytes, form: str, words: str) -> None:
    """What is no depth is refused."""
    with pytest.raises(FrameError, match=words):
        decode_depth(data, form)
