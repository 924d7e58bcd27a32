"""Compressed images as image_transport's plugins send them, decoded."""

from __future__ import annotations

import struct
from typing import Any

import cv2
import numpy as np
from mbd_model.errors import MbdError
from numpy.typing import NDArray

# compressed_depth_image_transport's ConfigHeader: int32 format, float32 depthParam[2].
HEADER = struct.Struct("<iff")


class ImageError(MbdError):
    """A compressed image that cannot be decoded."""


def decode_color(data: bytes) -> NDArray[np.uint8]:
    """(H, W, 3) uint8 RGB of a JPEG or PNG; raises ImageError when it is none."""
    pixels = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    if pixels is None:
        raise ImageError("a compressed colour image is no JPEG or PNG")
    return np.asarray(pixels[..., ::-1], dtype=np.uint8)


def decode_depth(data: bytes, encoding: str) -> NDArray[Any]:
    """(H, W) depth of a compressedDepth image: uint16 [mm] of 16UC1, float32 [m] of 32FC1.

    Args:
        data: with its header of 12 bytes.
        encoding: of the depth that was compressed.

    Raises:
        ImageError: it is no PNG behind such a header.
    """
    if len(data) <= HEADER.size:
        raise ImageError("a compressedDepth image is shorter than its header")
    _, a, b = HEADER.unpack_from(data)
    pixels = cv2.imdecode(np.frombuffer(data, np.uint8, offset=HEADER.size), cv2.IMREAD_UNCHANGED)
    if pixels is None or pixels.ndim != 2:
        raise ImageError("a compressedDepth image holds no PNG of one channel; RVL is not supported: set format to png")
    if encoding == "16UC1":
        return np.asarray(pixels, dtype=np.uint16)
    # Floats travel as inverse depth; 0 stands for no return.
    inverse = pixels.astype(np.float32)
    with np.errstate(divide="ignore"):
        return np.where(inverse > 0, np.float32(a) / (inverse - np.float32(b)), np.float32(np.nan)).astype(np.float32)
