"""Images as image_transport's plugins compress them: colour as JPEG or PNG, depth as PNG or RVL behind a header.

What a message's ``format`` states, as compressed_image_transport and compressed_depth_image_transport write it:
``rgb8; jpeg compressed bgr8``, ``16UC1; png compressed``, ``16UC1; compressedDepth png``,
``32FC1; compressedDepth rvl``; drivers that compress themselves write ``jpeg`` or ``png`` alone.
"""

from __future__ import annotations

import struct
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from mbd_perception.frames.frame import FrameError
from mbd_perception.frames.rvl import decode_rvl

# compressed_depth_image_transport's ConfigHeader: format, and A and B of the quantisation of inverse depth.
DEPTH_HEADER = struct.Struct("<iff")
DEPTH_MARK = "compressedDepth"
# A pixel without a value must not cost a division by zero.
TINY = np.float32(1e-6)


def decode_color(data: bytes | memoryview, form: str) -> NDArray[np.uint8]:
    """(height, width, 3) uint8 RGB of a compressed colour or grey image.

    Args:
        data: the file in it.
        form: what the message states as its ``format``.

    Raises:
        FrameError: the bytes are no picture, or hold no colour.
    """
    picture = _decoded(data, form)
    if picture.dtype == np.uint16:
        picture = (picture >> 8).astype(np.uint8)
    if picture.dtype != np.uint8:
        raise FrameError(f"compressed colour image ('{form}') holds {picture.dtype} pixels, expected 8 or 16 bits")
    if picture.ndim == 2:
        return np.repeat(picture[..., None], 3, axis=2)
    # OpenCV puts blue first; a publisher that compressed RGB as it was says so.
    _, _, how = form.partition(";")
    order = slice(None) if "compressed rgb" in how else slice(None, None, -1)
    return np.ascontiguousarray(picture[..., :3][..., order])


def decode_depth(data: bytes | memoryview, form: str) -> NDArray[np.uint16] | NDArray[np.float32]:
    """(height, width) depth of a compressed image: uint16 mm, or float32 m (NaN: none).

    Args:
        data: what the message carries: with ``compressedDepth`` a header of 12 bytes, then PNG or RVL; else PNG.
        form: what the message states as its ``format``.

    Raises:
        FrameError: the bytes are cut off or no depth image.
    """
    encoding, _, how = form.partition(";")
    if DEPTH_MARK not in how:
        return _sixteen_bit(_decoded(data, form), form)
    if len(data) <= DEPTH_HEADER.size:
        raise FrameError(f"compressed depth image ('{form}') of {len(data)} bytes is cut off: its header takes 12")
    _, scale, shift = DEPTH_HEADER.unpack_from(data)
    body = data[DEPTH_HEADER.size :]
    values = decode_rvl(body) if "rvl" in how else _sixteen_bit(_decoded(body, form), form)
    if not encoding.startswith("32"):
        return values
    if not (np.isfinite(scale) and np.isfinite(shift) and scale > 0):
        raise FrameError(f"compressed depth image ('{form}') states a quantisation of {scale:g} and {shift:g}: damaged")
    inverse = values.astype(np.float32) - np.float32(shift)
    usable = (values > 0) & (inverse > TINY)
    return np.where(usable, np.float32(scale) / np.where(usable, inverse, 1), np.float32(np.nan)).astype(np.float32)


def _sixteen_bit(picture: NDArray[Any], form: str) -> NDArray[np.uint16]:
    """The picture, which must be one of depth; raises FrameError."""
    if picture.dtype != np.uint16 or picture.ndim != 2:
        raise FrameError(
            f"compressed depth image ('{form}') holds {picture.dtype} of shape {picture.shape}, expected one channel "
            "of 16 bits: JPEG keeps no depth; publish compressedDepth, or PNG"
        )
    return picture


def _decoded(data: bytes | memoryview, form: str) -> NDArray[Any]:
    """The picture of a file in memory; raises FrameError."""
    try:
        picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED) if len(data) else None
    except cv2.error as error:
        raise FrameError(f"compressed image ('{form}') cannot be decoded ({error.err}): it is damaged") from error
    if picture is None:
        raise FrameError(f"compressed image ('{form}', {len(data)} bytes) cannot be decoded: it is damaged")
    return np.asarray(picture)
