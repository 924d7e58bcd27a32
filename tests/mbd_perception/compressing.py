"""Images compressed as image_transport's plugins do it, written from their sources' description for tests."""

from __future__ import annotations

import struct

import cv2
import numpy as np

# depth_quantization and depth_max of compressed_depth_image_transport, as shipped.
QUANTIZATION, FARTHEST = 100.0, 10.0


def png(picture: np.ndarray) -> bytes:
    """A PNG file."""
    return cv2.imencode(".png", picture)[1].tobytes()


def rvl(picture: np.ndarray) -> bytes:
    """(height, width) uint16 in RVL, size before it."""
    nibbles: list[int] = []

    def number(value: int) -> None:
        while True:
            value, low = value >> 3, value & 7
            nibbles.append(low | (8 if value else 0))
            if not value:
                return

    flat = [int(v) for v in picture.ravel()]
    at = previous = 0
    while at < len(flat):
        start = at
        while at < len(flat) and flat[at] == 0:
            at += 1
        number(at - start)
        start = at
        while at < len(flat) and flat[at] != 0:
            at += 1
        number(at - start)
        for value in flat[start:at]:
            difference = value - previous
            number(2 * difference if difference >= 0 else -2 * difference - 1)
            previous = value
    nibbles += [0] * (-len(nibbles) % 8)
    words = [int("".join(f"{n:x}" for n in nibbles[i : i + 8]), 16) for i in range(0, len(nibbles), 8)]
    return struct.pack(f"<II{len(words)}I", picture.shape[1], picture.shape[0], *words)


def with_header(body: bytes, scale: float = 0.0, shift: float = 0.0) -> bytes:
    """What compressedDepth puts before a file."""
    return struct.pack("<iff", 0, scale, shift) + body


def quantised(metres: np.ndarray) -> tuple[np.ndarray, float, float]:
    """Float depth [m] as 16 bits of inverse depth, with the two numbers that undo it."""
    scale = QUANTIZATION * (QUANTIZATION + 1.0)
    shift = 1.0 - scale / FARTHEST
    known = np.isfinite(metres) & (metres > 0) & (metres < FARTHEST)
    inverse = np.where(known, scale / np.where(known, metres, 1.0) + shift, 0.0)
    return inverse.astype(np.uint16), scale, shift
