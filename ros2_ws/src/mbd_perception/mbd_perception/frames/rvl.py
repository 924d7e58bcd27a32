"""Depth images in RVL, the code that image_transport's compressedDepth knows beside PNG (A. D. Wilson, 2017).

A stream of numbers: how many pixels have no depth, how many have one, the differences of those to the pixel before,
and again. A number is written in groups of three bits, the lowest first, with a fourth bit set where one more follows;
eight such nibbles, the first in the highest bits, make a little-endian word.
"""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

from mbd_perception.frames.frame import FrameError

# Width and height [px] before the stream, as compressed_depth_image_transport writes them.
SIZE = struct.Struct("<II")
# A number takes a nibble at least, and two make a run, which may hold any number of pixels without depth; what is
# larger than any camera's picture is no size.
MOST_PIXELS = 40_000_000
# No pixel or run needs more nibbles than that.
LONGEST = 11


def decode_rvl(data: bytes | memoryview) -> NDArray[np.uint16]:
    """(height, width) uint16 of what follows the header of compressedDepth: size, then stream.

    Raises:
        FrameError: the bytes end too early or hold more than they state.
    """
    if len(data) < SIZE.size:
        raise FrameError(f"RVL depth image of {len(data)} bytes is cut off: its size alone takes {SIZE.size}")
    width, height = SIZE.unpack_from(data)
    pixels = width * height
    if not 0 < pixels <= MOST_PIXELS:
        raise FrameError(f"RVL depth image states {width}x{height} pixels: it is damaged, or no RVL")
    numbers = _numbers(data[SIZE.size : SIZE.size + (len(data) - SIZE.size) // 4 * 4])
    values, filled = _runs(numbers, pixels)
    depth = np.zeros(pixels, dtype=np.uint16)
    depth[filled] = values
    return depth.reshape(height, width)


def _numbers(data: bytes | memoryview) -> NDArray[np.int64]:
    """All numbers of a stream, those after its end included."""
    words = np.frombuffer(data, "<u4")
    nibbles = (words[:, None] >> np.arange(28, -4, -4, dtype=np.uint32) & 0xF).astype(np.int64).ravel()
    last = np.flatnonzero(nibbles < 8)
    if last.size == 0:
        return np.zeros(0, dtype=np.int64)
    first = np.concatenate([[0], last[:-1] + 1])
    nibbles = nibbles[: last[-1] + 1]
    place = np.arange(len(nibbles)) - np.repeat(first, last - first + 1)
    return np.asarray(np.add.reduceat((nibbles & 7) << 3 * np.minimum(place, LONGEST), first), dtype=np.int64)


def _runs(numbers: NDArray[np.int64], pixels: int) -> tuple[NDArray[np.uint16], NDArray[np.bool_]]:
    """Values of the pixels that have one, and (pixels,) bool which those are; raises FrameError."""
    filled = np.zeros(pixels, dtype=np.bool_)
    is_difference = np.zeros(len(numbers), dtype=np.bool_)
    at = done = 0
    while done < pixels:
        if at + 2 > len(numbers):
            raise FrameError(f"RVL depth image is cut off: {done} of its {pixels} pixels are there")
        empty, full = int(numbers[at]), int(numbers[at + 1])
        done += empty
        if empty + full == 0 or done + full > pixels:
            raise FrameError(f"RVL depth image is damaged: its runs do not add up to its {pixels} pixels")
        if at + 2 + full > len(numbers):
            raise FrameError(f"RVL depth image is cut off within a run, at pixel {done} of {pixels}")
        is_difference[at + 2 : at + 2 + full] = True
        filled[done : done + full] = True
        done += full
        at += 2 + full
    code = numbers[is_difference]
    difference = code >> 1 ^ -(code & 1)
    return np.cumsum(difference).astype(np.uint16), filled
