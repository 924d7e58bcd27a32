"""Compressed images carry what the raw ones held, in the layout of ROS's own messages and image_transport."""

from __future__ import annotations

import array
import struct

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_bag.errors import BagError
from mbd_bag.images.image_cdr import read_compressed, read_image, write_image
from mbd_bag.images.image_compression import COLOR_SUFFIX, DEPTH_SUFFIX, compress, decompress, decompress_message
from mbd_bag.recorder.thinning import Thinning, header_stamp
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import Header

TEXTS = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=9)


def image(pixels: np.ndarray, encoding: str, *, padding: int = 0, frame_id: str = "camera") -> Image:
    """A message of these pixels, each row followed by padding bytes."""
    height, width = pixels.shape[:2]
    rows = np.ascontiguousarray(pixels).view(np.uint8).reshape(height, -1)
    rows = np.pad(rows, ((0, 0), (0, padding)), constant_values=77)
    header = Header(frame_id=frame_id)
    header.stamp.sec, header.stamp.nanosec = 12, 345
    msg = Image(header=header, height=height, width=width, encoding=encoding, step=rows.shape[1])
    msg.data = array.array("B", rows.tobytes())
    return msg


def smooth(rng: np.random.Generator, channels: int = 3) -> np.ndarray:
    """A picture that JPEG is made for: (48, 64, channels)."""
    small = rng.integers(0, 256, (3, 4, channels), dtype=np.uint8)
    return cv2.resize(small, (64, 48), interpolation=cv2.INTER_CUBIC).reshape(48, 64, channels)


@given(TEXTS, TEXTS, st.integers(0, 40), st.integers(0, 2**31 - 1), st.integers(0, 999_999_999))
def test_the_bytes_are_those_of_the_ros_messages(frame: str, encoding: str, size: int, sec: int, nanosec: int):
    msg = Image(height=3, width=5, encoding=encoding, step=size, is_bigendian=1)
    msg.header.frame_id = frame
    msg.header.stamp.sec, msg.header.stamp.nanosec = sec, nanosec
    msg.data = array.array("B", range(size))
    data = serialize_message(msg)
    read = read_image(data)
    assert (read.stamp, read.frame_id, read.encoding) == ((sec, nanosec), frame, encoding)
    assert (read.height, read.width, read.step, read.bigendian, bytes(read.data)) == (3, 5, size, True, bytes(msg.data))
    assert deserialize_message(write_image(read), Image) == msg
    assert header_stamp(data) == sec * 10**9 + nanosec


@given(st.integers(0, 2**32 - 1), st.integers(0, 5), st.sampled_from(["16UC1", "mono16"]))
def test_depth_is_lossless_whatever_its_values(seed: int, padding: int, encoding: str):
    depth = np.random.default_rng(seed).integers(0, 2**16, (9, 14), dtype=np.uint16)
    msg = image(depth, encoding, padding=2 * padding)
    made = compress(serialize_message(msg), 90)
    assert made is not None
    assert made.suffix == DEPTH_SUFFIX == "/compressedDepth"
    back = decompress(made.data)
    assert (np.frombuffer(back.data, np.uint16).reshape(depth.shape) == depth).all()
    assert (back.encoding, back.stamp, back.frame_id, back.step) == (encoding, (12, 345), "camera", 28)


@pytest.mark.parametrize("encoding", ["rgb8", "bgr8", "mono8", "rgba8", "bgra8"])
def test_colour_keeps_its_channels_in_order_and_loses_little(encoding: str):
    channels = {"mono8": 1, "rgba8": 4, "bgra8": 4}.get(encoding, 3)
    pixels = smooth(np.random.default_rng(3), channels)
    made = compress(serialize_message(image(pixels, encoding, padding=3)), 95)
    assert made is not None
    assert made.suffix == COLOR_SUFFIX == "/compressed"
    back = decompress(made.data)
    shown = np.frombuffer(back.data, np.uint8).reshape(48, 64, -1)
    assert back.encoding == encoding.replace("a8", "8")
    assert np.abs(shown.astype(int) - pixels[..., :3]).mean() < 3.0


def test_what_is_written_is_what_image_transport_reads():
    rng = np.random.default_rng(1)
    color = deserialize_message(compress(serialize_message(image(smooth(rng), "rgb8")), 90).data, CompressedImage)
    assert color.format == "rgb8; jpeg compressed bgr8"
    assert bytes(color.data[:3]) == b"\xff\xd8\xff"
    depth_image = image(np.full((4, 6), 812, np.uint16), "16UC1")
    depth = deserialize_message(compress(serialize_message(depth_image), 90).data, CompressedImage)
    assert depth.format == "16UC1; compressedDepth png"
    assert struct.unpack("<iff", bytes(depth.data[:12])) == (0, 0.0, 0.0)
    assert bytes(depth.data[12:16]) == b"\x89PNG"
    assert deserialize_message(decompress_message(serialize_message(depth)), Image) == depth_image


def test_depth_in_metres_is_left_raw_rather_than_rounded():
    assert compress(serialize_message(image(np.ones((4, 4), np.float32), "32FC1")), 90) is None


def test_images_cut_off_or_damaged_are_refused():
    cut = image(np.zeros((4, 4, 3), np.uint8), "rgb8")
    cut.data = cut.data[:20]
    with pytest.raises(BagError, match="20 bytes"):
        compress(serialize_message(cut), 90)
    with pytest.raises(BagError, match="no sensor_msgs/msg/Image"):
        read_image(serialize_message(image(np.zeros((4, 4, 3), np.uint8), "rgb8"))[:40])
    with pytest.raises(BagError, match="CompressedImage"):
        read_compressed(b"\x00\x01\x00\x00\x01")
    for text, data in (("rgb8; jpeg compressed bgr8", b"none"), ("16UC1; compressedDepth png", bytes(12))):
        with pytest.raises(BagError, match="cannot be decoded"):
            decompress(serialize_message(CompressedImage(format=text, data=array.array("B", data))))
    with pytest.raises(BagError, match="32FC1"):
        decompress(serialize_message(CompressedImage(format="32FC1; compressedDepth png", data=array.array("B", b"x"))))


@given(st.lists(st.integers(0, 10**11), min_size=1, max_size=50).map(sorted), st.sampled_from([0.5, 2.0, 30.0]))
def test_thinning_keeps_the_same_moments_of_every_stream_at_most_one_a_period(stamps: list[int], rate: float):
    def kept() -> list[int]:
        thinning, moments = Thinning(rate), []
        for stamp in stamps:
            msg = Image()
            msg.header.stamp.sec, msg.header.stamp.nanosec = divmod(stamp, 10**9)
            if thinning.keeps(serialize_message(msg)):
                moments.append(stamp)
        return moments

    assert kept() == kept()
    assert len({int(s * rate / 1e9) for s in kept()}) == len(kept()) == len({int(s * rate / 1e9) for s in stamps})
