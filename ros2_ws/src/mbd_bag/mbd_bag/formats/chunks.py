"""The chunks of an MCAP file: decompressed within bounds, and taken apart without copying their messages."""

from __future__ import annotations

import struct
from array import array
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO
from typing import Any, Final
from zlib import crc32

import lz4.frame
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Schema

# A record has to fit into memory twice. The largest we know is a point cloud of a 4K camera [byte].
LARGEST_RECORD: Final = 128 << 20
RECORD_HEADER: Final = 9  # opcode and length
_MESSAGE_HEADER = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
# What the mcap library and the decompressors raise on bytes that are not what they should be.
# A length with a flipped bit asks for more memory than there is.
DAMAGE = (
    McapError,
    struct.error,
    RuntimeError,
    ValueError,
    KeyError,
    OverflowError,
    MemoryError,
    zstandard.ZstdError,
)


def parse(record: Any, payload: bytes | memoryview) -> Any:
    """A record of the mcap library from its bytes; raises one of DAMAGE."""
    return record.read(ReadDataStream(BytesIO(payload)))


def decompressed(chunk: Chunk) -> bytes:
    """The records of a chunk, checked against its size and checksum.

    Raises:
        ValueError: they are larger than LARGEST_RECORD, or not what the chunk states; or another of DAMAGE.
    """
    size = chunk.uncompressed_size
    if size > LARGEST_RECORD:
        raise ValueError(f"a chunk would take {size} bytes of memory; {LARGEST_RECORD} are allowed")
    if chunk.compression == "zstd":
        stated = zstandard.frame_content_size(chunk.data)
        if stated not in (-1, size):
            raise ValueError(f"a chunk of {size} bytes is compressed from {stated}")
        data = zstandard.ZstdDecompressor().decompress(chunk.data, max_output_size=size) if size else b""
    elif chunk.compression == "lz4":
        data = lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=size + 1) if size else b""
    elif chunk.compression == "":
        data = chunk.data
    else:
        raise ValueError(f"compression '{chunk.compression}' of a chunk is none of lz4, zstd")
    if len(data) != size:
        raise ValueError(f"a chunk of {size} bytes holds {len(data)}")
    if chunk.uncompressed_crc and crc32(data) != chunk.uncompressed_crc:
        raise ValueError("a chunk's checksum is wrong")
    return data


@dataclass
class ChunkRecords:
    """The records of one chunk.

    Attributes:
        data: decompressed bytes.
        schemas, channels: declared in it.
        ids: channel id of each message.
        times: log time of each message [ns].
        offsets: where each message's record begins in ``data`` [byte].
    """

    data: bytes
    schemas: list[Schema] = field(default_factory=list)
    channels: list[Channel] = field(default_factory=list)
    ids: array[int] = field(default_factory=lambda: array("H"))
    times: array[int] = field(default_factory=lambda: array("Q"))
    offsets: array[int] = field(default_factory=lambda: array("Q"))


def inner_records(data: bytes) -> Iterator[tuple[int, int, int]]:
    """(opcode, offset, end) of each record in a row of records; raises ValueError when the last one is cut."""
    offset, size = 0, len(data)
    while offset < size:
        if offset + RECORD_HEADER > size:
            raise ValueError("a record in a chunk is cut")
        opcode = data[offset]
        end = offset + RECORD_HEADER + int.from_bytes(data[offset + 1 : offset + RECORD_HEADER], "little")
        if end > size:
            raise ValueError("a record in a chunk is longer than the chunk")
        yield opcode, offset, end
        offset = end


def take_apart(data: bytes) -> ChunkRecords:
    """What a decompressed chunk holds; raises one of DAMAGE."""
    found = ChunkRecords(data)
    for opcode, offset, end in inner_records(data):
        if opcode == Opcode.MESSAGE:
            if end - offset < RECORD_HEADER + _MESSAGE_HEADER.size:
                raise ValueError("a message in a chunk is cut")
            channel, _, log_time, _ = _MESSAGE_HEADER.unpack_from(data, offset + RECORD_HEADER)
            found.ids.append(channel)
            found.times.append(log_time)
            found.offsets.append(offset)
        elif opcode == Opcode.SCHEMA:
            found.schemas.append(parse(Schema, data[offset + RECORD_HEADER : end]))
        elif opcode == Opcode.CHANNEL:
            found.channels.append(parse(Channel, data[offset + RECORD_HEADER : end]))
    return found


@dataclass(frozen=True)
class RawMessage:
    """A message record: its channel id, sequence number, log and publish time [ns], and CDR bytes."""

    channel: int
    sequence: int
    log_time: int
    publish_time: int
    data: bytes


def raw_message(data: bytes, offset: int = 0) -> RawMessage:
    """The message whose record begins at an offset; raises struct.error when it is cut."""
    length = int.from_bytes(data[offset + 1 : offset + RECORD_HEADER], "little")
    begin = offset + RECORD_HEADER
    channel, sequence, log_time, publish_time = _MESSAGE_HEADER.unpack_from(data, begin)
    payload = data[begin + _MESSAGE_HEADER.size : begin + length]
    return RawMessage(channel, sequence, log_time, publish_time, payload)
