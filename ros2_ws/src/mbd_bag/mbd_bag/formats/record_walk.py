"""The records of an MCAP file one after the other, without reading more of each than is asked for."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import BinaryIO

from mbd_bag.formats.chunks import LARGEST_RECORD, RECORD_HEADER

MAGIC = b"\x89MCAP0\r\n"


@dataclass(frozen=True)
class Place:
    """A record in a file.

    Attributes:
        opcode: its kind.
        offset: where it begins [byte].
        length: of its payload [byte].
    """

    opcode: int
    offset: int
    length: int

    @property
    def end(self) -> int:
        """Offset behind it [byte]."""
        return self.offset + RECORD_HEADER + self.length


def places(stream: BinaryIO, start: int, end: int) -> Iterator[Place]:
    """Each record that is not cut, from an offset on.

    Args:
        stream: the file.
        start: where the first record begins [byte].
        end: where the last one may end [byte].
    """
    offset = start
    while offset + RECORD_HEADER <= end:
        stream.seek(offset)
        head = stream.read(RECORD_HEADER)
        if len(head) < RECORD_HEADER:
            return
        place = Place(head[0], offset, int.from_bytes(head[1:], "little"))
        if place.end > end:
            return
        yield place
        offset = place.end


def payload(stream: BinaryIO, place: Place) -> bytes:
    """The bytes of a record; raises ValueError when they are more than is allowed, or missing."""
    if place.length > LARGEST_RECORD:
        raise ValueError(f"a record of {place.length} bytes is larger than the {LARGEST_RECORD} allowed")
    stream.seek(place.offset + RECORD_HEADER)
    data = stream.read(place.length)
    if len(data) < place.length:
        raise ValueError("a record is cut")
    return data
