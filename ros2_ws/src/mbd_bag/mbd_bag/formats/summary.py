"""The summary at the end of an MCAP file: what it holds, without reading all of it."""

from __future__ import annotations

import struct
from typing import BinaryIO
from zlib import crc32

from mcap.opcode import Opcode
from mcap.records import Channel, ChunkIndex, Metadata, MetadataIndex, Schema, Statistics

from mbd_bag.formats.chunks import DAMAGE, RECORD_HEADER, inner_records, parse
from mbd_bag.formats.contents import FileContents
from mbd_bag.formats.record_walk import MAGIC, Place, payload

_FOOTER = struct.Struct("<BQQQI")  # opcode, length, summary start, summary offset start, checksum
_LARGEST_SUMMARY = 64 << 20
# A file may decompress to so many times its size, or to so many bytes: depth images without a scene reach 200.
_RATIO, _AT_LEAST = 300, 1 << 30


def summary_bytes(stream: BinaryIO, size: int) -> tuple[bytes, int] | None:
    """The summary section and where it begins [byte]; None when there is none, or its checksum is wrong.

    Args:
        stream: the file.
        size: its size [byte].
    """
    foot = size - _FOOTER.size - len(MAGIC)
    if foot < len(MAGIC):
        return None
    stream.seek(foot)
    record = stream.read(_FOOTER.size)
    opcode, length, start, _, checksum = _FOOTER.unpack(record)
    if opcode != Opcode.FOOTER or length != _FOOTER.size - RECORD_HEADER or stream.read(len(MAGIC)) != MAGIC:
        return None
    if not len(MAGIC) < start <= foot or foot - start > _LARGEST_SUMMARY:
        return None
    stream.seek(start)
    body = stream.read(foot - start)
    if checksum and crc32(record[:-4], crc32(body)) != checksum:
        return None
    return body, start


def read_summary(stream: BinaryIO, size: int) -> FileContents | None:
    """The contents by the summary section; None when it is missing, or does not tell all.

    Args:
        stream: the file.
        size: its size [byte].

    Raises:
        ValueError: the chunks decompress to more than a bag can be; or another of DAMAGE.
    """
    section = summary_bytes(stream, size)
    if section is None:
        return None
    body, start = section
    found = FileContents(data_end=start)
    statistics: Statistics | None = None
    indexes: list[MetadataIndex] = []
    for opcode, offset, end in inner_records(body):
        data = body[offset + RECORD_HEADER : end]
        if opcode == Opcode.SCHEMA:
            schema: Schema = parse(Schema, data)
            found.schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            channel: Channel = parse(Channel, data)
            found.channels[channel.id] = channel
        elif opcode == Opcode.CHUNK_INDEX:
            found.chunks.append(parse(ChunkIndex, data))
        elif opcode == Opcode.METADATA_INDEX:
            indexes.append(parse(MetadataIndex, data))
        elif opcode == Opcode.STATISTICS:
            statistics = parse(Statistics, data)
    if statistics is None or not _tells_all(found, statistics, len(indexes), start):
        return None
    refuse_bomb(sum(c.uncompressed_size for c in found.chunks), size)
    found.counts = {k: n for k, n in statistics.channel_message_counts.items() if n}
    found.start, found.end = statistics.message_start_time, statistics.message_end_time
    for index in indexes:
        place = Place(Opcode.METADATA, index.offset, index.length - RECORD_HEADER)
        if place.length < 0 or place.end > start:
            return None
        found.metadata.append((parse(Metadata, payload(stream, place)), None))
    return found


def _tells_all(found: FileContents, statistics: Statistics, metadata: int, start: int) -> bool:
    """Whether every message and record can be found by this summary: chunks in order, all declared, all counted."""
    counted = sum(statistics.channel_message_counts.values())
    end = len(MAGIC)
    for chunk in sorted(found.chunks, key=lambda c: c.chunk_start_offset):
        if chunk.chunk_start_offset < end:
            return False
        end = chunk.chunk_start_offset + chunk.chunk_length
    return (
        end <= start
        and (bool(found.chunks) or not counted)
        and statistics.chunk_count == len(found.chunks)
        and statistics.message_count == counted
        and statistics.metadata_count == metadata
        and statistics.channel_message_counts.keys() <= found.channels.keys()
        and all(c.schema_id in found.schemas or not c.schema_id for c in found.channels.values())
    )


def summary_agrees(stream: BinaryIO, size: int, found: FileContents) -> bool:
    """Whether a summary, that need not tell all, states nothing else than was found by reading all of the file.

    Args:
        stream: the file.
        size: its size [byte].
        found: record by record.
    """
    section = summary_bytes(stream, size)
    if section is None:
        return False
    chunks = {c.chunk_start_offset: c.uncompressed_size for c in found.chunks}
    try:
        for opcode, offset, end in inner_records(section[0]):
            data = section[0][offset + RECORD_HEADER : end]
            if opcode == Opcode.SCHEMA:
                schema: Schema = parse(Schema, data)
                right = found.schemas.get(schema.id) == schema
            elif opcode == Opcode.CHANNEL:
                channel: Channel = parse(Channel, data)
                right = found.channels.get(channel.id) == channel
            elif opcode == Opcode.CHUNK_INDEX:
                index: ChunkIndex = parse(ChunkIndex, data)
                right = chunks.get(index.chunk_start_offset) == index.uncompressed_size
            elif opcode == Opcode.STATISTICS:
                stated: Statistics = parse(Statistics, data)
                counts = {k: n for k, n in stated.channel_message_counts.items() if n}
                right = (counts, stated.message_count) == (found.counts, found.message_count)
            else:
                right = True
            if not right:
                return False
    except DAMAGE:
        return False
    return True


def refuse_bomb(decompressed: int, size: int) -> None:
    """Raises ValueError when a file decompresses to more than a recorded one can.

    Args:
        decompressed: of all its chunks together [byte].
        size: of the file [byte].
    """
    if decompressed > max(_AT_LEAST, _RATIO * size):
        raise ValueError(f"its {size} bytes would decompress to {decompressed}: that is no recorded session")
