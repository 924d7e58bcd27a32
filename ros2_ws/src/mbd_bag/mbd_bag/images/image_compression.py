"""Colour as JPEG, depth as lossless PNG, named and laid out as image_transport's plugins do it.

``<topic>/compressed`` holds colour in format ``rgb8; jpeg compressed bgr8``; ``<topic>/compressedDepth`` holds 16-bit
depth in format ``16UC1; compressedDepth png``: 12 bytes of header (unused for 16UC1) and a PNG. Any subscriber of
image_transport, Foxglove and rosbags-image read both.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mbd_bag.errors import BagError
from mbd_bag.images.image_cdr import RawImage, read_compressed, read_image, write_compressed, write_image

COLOR_SUFFIX, DEPTH_SUFFIX = "/compressed", "/compressedDepth"
SUFFIXES = (DEPTH_SUFFIX, COLOR_SUFFIX)
# compressed_depth_image_transport's ConfigHeader: int32 format, float32 depthParam[2]; read for 32FC1 only.
DEPTH_HEADER = bytes(12)

# How a colour encoding becomes the BGR that OpenCV encodes; None: it is that already.
_TO_BGR = {
    "rgb8": cv2.COLOR_RGB2BGR,
    "bgr8": None,
    "rgba8": cv2.COLOR_RGBA2BGR,
    "bgra8": cv2.COLOR_BGRA2BGR,
    "mono8": None,
}
_CHANNELS = {"rgb8": 3, "bgr8": 3, "rgba8": 4, "bgra8": 4, "mono8": 1}
_DEPTHS = ("16UC1", "mono16")
# Level 1 with Huffman codes only: noisy depth gets no smaller by searching for repetitions, only slower (4 x).
_PNG = [cv2.IMWRITE_PNG_COMPRESSION, 1, cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_HUFFMAN_ONLY]


@dataclass(frozen=True)
class CompressedMessage:
    """What to record in place of a raw image: the suffix of its topic's name, and CDR bytes of a CompressedImage."""

    suffix: str
    data: bytes


def _pixels(image: RawImage, channels: int, dtype: str) -> NDArray[np.generic]:
    """(height, width[, channels]) view; raises BagError when there are too few bytes."""
    kind = np.dtype(dtype).newbyteorder(">" if image.bigendian else "<")
    row = image.width * channels * kind.itemsize
    if image.step < row or len(image.data) < image.height * image.step or row == 0 or image.height == 0:
        raise BagError(
            f"{image.encoding} image of {image.width}x{image.height} has {len(image.data)} bytes in rows of "
            f"{image.step}; expected rows of {row} bytes or more: check the camera's driver"
        )
    rows = np.frombuffer(image.data, np.uint8, image.height * image.step).reshape(image.height, image.step)
    pixels = np.ascontiguousarray(rows[:, :row]).view(kind)
    shaped = pixels.reshape(image.height, image.width, channels) if channels > 1 else pixels
    return shaped.astype(kind.newbyteorder("="), copy=False)


def compress(message: bytes, quality: int) -> CompressedMessage | None:
    """A serialized Image, compressed; None when its encoding is one that would lose more than JPEG's noise.

    Args:
        message: CDR bytes of a sensor_msgs/Image.
        quality: of the JPEG, 1..100.

    Raises:
        BagError: the bytes are no image.
    """
    image = read_image(message)
    if image.encoding in _TO_BGR:
        pixels = _pixels(image, _CHANNELS[image.encoding], "u1")
        conversion = _TO_BGR[image.encoding]
        shown = pixels if conversion is None else cv2.cvtColor(pixels, conversion)
        # Full colour resolution: perception takes an object's hue from it.
        flags = [cv2.IMWRITE_JPEG_QUALITY, quality]
        flags += [cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444]
        _, encoded = cv2.imencode(".jpg", shown, flags)
        target = "mono8" if image.encoding == "mono8" else "bgr8"
        text = f"{image.encoding}; jpeg compressed {target}"
        return CompressedMessage(COLOR_SUFFIX, write_compressed(image.stamp, image.frame_id, text, encoded.data))
    if image.encoding in _DEPTHS:
        _, encoded = cv2.imencode(".png", _pixels(image, 1, "u2"), _PNG)
        text = f"{image.encoding}; compressedDepth png"
        data = DEPTH_HEADER + encoded.tobytes()
        return CompressedMessage(DEPTH_SUFFIX, write_compressed(image.stamp, image.frame_id, text, data))
    return None


def decompress(message: bytes) -> RawImage:
    """The Image of a serialized CompressedImage, in the encoding it was published in (rgb8, bgr8, mono8, 16UC1).

    Raises:
        BagError: its format or bytes are not what `compress` or image_transport write.
    """
    image = read_compressed(message)
    encoding, _, how = image.format.partition("; ")
    depth = how.startswith("compressedDepth")
    if depth and encoding not in _DEPTHS:
        raise BagError(f"depth in format '{image.format}' cannot be read; expected 16UC1 (record 32FC1 raw)")
    body = image.data[len(DEPTH_HEADER) :] if depth else image.data
    pixels = cv2.imdecode(np.frombuffer(body, np.uint8), cv2.IMREAD_UNCHANGED) if len(body) else None
    if pixels is None:
        raise BagError(f"a compressed image ('{image.format}', {len(body)} bytes) cannot be decoded: it is damaged")
    if depth != (pixels.dtype == np.uint16):
        raise BagError(f"a compressed image states '{image.format}' but holds {pixels.dtype} of shape {pixels.shape}")
    if not depth:
        wanted = encoding if encoding in _TO_BGR else "rgb8"
        pixels, encoding = _in_encoding(pixels, wanted)
    height, width = pixels.shape[:2]
    data = np.ascontiguousarray(pixels).data.cast("B")
    return RawImage(image.stamp, image.frame_id, height, width, encoding, False, len(data) // height, data)


def _in_encoding(pixels: NDArray[np.uint8], encoding: str) -> tuple[NDArray[np.uint8], str]:
    """Pixels as OpenCV decodes them, in an encoding without alpha."""
    if pixels.ndim == 2:
        return pixels, "mono8"
    if encoding.startswith("bgr"):
        return pixels, "bgr8"
    return cv2.cvtColor(pixels, cv2.COLOR_BGR2RGB), "rgb8"


def depth_pixels(image: RawImage) -> NDArray[np.uint16] | NDArray[np.float32]:
    """(height, width) depth, uint16 millimetres or float32 metres; raises BagError for another encoding."""
    if image.encoding not in (*_DEPTHS, "32FC1"):
        raise BagError(f"depth in encoding '{image.encoding}' cannot be read; expected 16UC1 or 32FC1")
    metres = image.encoding == "32FC1"
    pixels: NDArray[np.uint16] | NDArray[np.float32]
    pixels = _pixels(image, 1, "f4").view(np.float32) if metres else _pixels(image, 1, "u2").view(np.uint16)
    return pixels


def decompress_message(message: bytes) -> bytes:
    """CDR bytes of the Image that a serialized CompressedImage holds; raises BagError as `decompress`."""
    return write_image(decompress(message))
