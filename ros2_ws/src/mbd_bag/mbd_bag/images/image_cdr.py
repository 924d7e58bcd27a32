"""The bytes of sensor_msgs/Image and CompressedImage (CDR version 1), so that a recorder needs no message objects.

A recorder gets each message serialized and hands on another one serialized: between them only the pixels matter.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from mbd_bag.errors import BagError

IMAGE = "sensor_msgs/msg/Image"
COMPRESSED_IMAGE = "sensor_msgs/msg/CompressedImage"
# Encapsulation: plain CDR, little endian, no options. Alignment counts from behind it.
_LITTLE = b"\x00\x01\x00\x00"


@dataclass(frozen=True)
class RawImage:
    """A sensor_msgs/Image.

    Attributes:
        stamp: (seconds, nanoseconds).
        frame_id: of the camera's optical frame.
        height, width: [px].
        encoding: as in sensor_msgs/image_encodings.h.
        bigendian: of pixels wider than a byte.
        step: bytes of a row.
        data: height * step bytes.
    """

    stamp: tuple[int, int]
    frame_id: str
    height: int
    width: int
    encoding: str
    bigendian: bool
    step: int
    data: memoryview


@dataclass(frozen=True)
class CompressedImage:
    """A sensor_msgs/CompressedImage: stamp and frame as in `RawImage`, image_transport's format text, the bytes."""

    stamp: tuple[int, int]
    frame_id: str
    format: str
    data: memoryview


class _Reader:
    """Takes fields one after the other; raises struct.error behind the end."""

    def __init__(self, message: bytes) -> None:
        self._bytes = memoryview(message)[4:]
        self._order = "<" if message[1] & 1 else ">"
        self._at = 0

    def number(self, code: str) -> int:
        size = struct.calcsize(code)
        self._at += -self._at % size
        (value,) = struct.unpack_from(self._order + code, self._bytes, self._at)
        self._at += size
        return int(value)

    def stamp(self) -> tuple[int, int]:
        return self.number("i"), self.number("I")

    def block(self) -> memoryview:
        length = self.number("I")
        if self._at + length > len(self._bytes):
            raise struct.error(f"{length} bytes announced, {len(self._bytes) - self._at} left")
        self._at += length
        return self._bytes[self._at - length : self._at]

    def text(self) -> str:
        return bytes(self.block()).rstrip(b"\0").decode()


def read_image(message: bytes) -> RawImage:
    """An Image of its CDR bytes, the pixels not copied; raises BagError when they are none."""
    try:
        reader = _Reader(message)
        stamp, frame_id, height, width = reader.stamp(), reader.text(), reader.number("I"), reader.number("I")
        encoding, bigendian, step = reader.text(), bool(reader.number("B")), reader.number("I")
        return RawImage(stamp, frame_id, height, width, encoding, bigendian, step, reader.block())
    except (struct.error, IndexError, UnicodeDecodeError) as error:
        raise BagError(f"a message is no {IMAGE} ({error}); was it recorded with another definition?") from error


def read_compressed(message: bytes) -> CompressedImage:
    """A CompressedImage of its CDR bytes; raises BagError when they are none."""
    try:
        reader = _Reader(message)
        return CompressedImage(reader.stamp(), reader.text(), reader.text(), reader.block())
    except (struct.error, IndexError, UnicodeDecodeError) as error:
        raise BagError(f"a message is no {COMPRESSED_IMAGE} ({error}); was it recorded with another one?") from error


def _padded(body: bytearray, size: int) -> bytearray:
    body += bytes(-len(body) % size)
    return body


def _add_text(body: bytearray, text: str) -> None:
    encoded = text.encode() + b"\0"
    _padded(body, 4).extend(struct.pack("<I", len(encoded)))
    body += encoded


def _add_block(body: bytearray, data: bytes | memoryview) -> bytes:
    _padded(body, 4).extend(struct.pack("<I", len(data)))
    return b"".join((_LITTLE, body, data))


def write_compressed(stamp: tuple[int, int], frame_id: str, format_text: str, data: bytes | memoryview) -> bytes:
    """CDR bytes of a CompressedImage; arguments as its attributes."""
    body = bytearray(struct.pack("<iI", *stamp))
    _add_text(body, frame_id)
    _add_text(body, format_text)
    return _add_block(body, data)


def write_image(image: RawImage) -> bytes:
    """CDR bytes of an Image."""
    body = bytearray(struct.pack("<iI", *image.stamp))
    _add_text(body, image.frame_id)
    _padded(body, 4).extend(struct.pack("<II", image.height, image.width))
    _add_text(body, image.encoding)
    body.append(image.bigendian)
    _padded(body, 4).extend(struct.pack("<I", image.step))
    return _add_block(body, image.data)
