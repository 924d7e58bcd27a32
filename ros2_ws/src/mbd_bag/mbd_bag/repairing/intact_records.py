"""Find the records of a damaged MCAP file that are intact, also behind the damage.

A chunk is intact when its checksum says so. Whatever lies between intact chunks and cannot be read is passed over: to
the end of the damaged record where its length leads to another record, else to the next chunk that is intact. Messages
are never taken out of a damaged chunk: which of them is the damaged one cannot be known.
"""

from __future__ import annotations

import re
import struct
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO
from typing import Final
from zlib import crc32

from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, MessageIndex, Metadata, Schema

from mbd_bag.formats.chunks import (
    DAMAGE,
    LARGEST_RECORD,
    RECORD_HEADER,
    ChunkRecords,
    decompressed,
    inner_records,
    parse,
    raw_message,
    take_apart,
)
from mbd_bag.formats.record_walk import MAGIC
from mbd_bag.formats.summary import summary_bytes
from mbd_bag.repairing.partial_chunk import declarations, makes_sense, names_a_topic

# A chunk's record up to its compression: opcode, length, times, size, checksum.
_CHUNK: Final = re.compile(rb"\x06.{5}\x00{3}.{28}(?:\x03\0\0\0lz4|\x04\0\0\0zstd|\0\0\0\0)", re.DOTALL)
# Where any record may begin: a known kind, and a length that no file of 4 GB exceeds.
_RECORD: Final = re.compile(rb"[\x01-\x0f].{4}\x00{4}", re.DOTALL)
_CHUNK_HEAD: Final = 8 + 8 + 8 + 4
_ATTACHMENT_HEAD: Final = 8 + 8 + 4 + 4 + 8  # times and the lengths of name, type and content
_KNOWN: Final = frozenset(range(Opcode.HEADER, Opcode.DATA_END + 1))


@dataclass
class IntactRecords:
    """What is intact in a file.

    Attributes:
        schemas, channels: by id, each by its most trusted declaration.
        chunks: offset of each intact chunk [byte].
        loose: offset of each message outside chunks [byte].
        metadata, attachments: records in file order.
        compression: of the chunks; "" when there is none.
        damaged: bytes that could not be read.
        damages: places at which something could not be read.
        doubtful_schemas, doubtful_channels: declared outside chunks, without a checksum, or in damaged chunks.
        index_schemas, index_channels: declared behind the data's end; of use without its checksum, if confirmed.
        indexed: messages by channel id that the message indexes list, those of damaged chunks too.
        in_summary: True once the data section's end was passed, behind which declarations count by checksum only.
    """

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    chunks: list[int] = field(default_factory=list)
    loose: list[int] = field(default_factory=list)
    metadata: list[Metadata] = field(default_factory=list)
    attachments: list[Attachment] = field(default_factory=list)
    compression: str = ""
    damaged: int = 0
    damages: int = 0
    doubtful_schemas: list[Schema] = field(default_factory=list)
    doubtful_channels: list[Channel] = field(default_factory=list)
    index_schemas: list[Schema] = field(default_factory=list)
    index_channels: list[Channel] = field(default_factory=list)
    indexed: Counter[int] = field(default_factory=Counter)
    in_summary: bool = False


def chunk_at(view: memoryview, offset: int) -> ChunkRecords:
    """The intact chunk whose record begins at an offset; raises one of DAMAGE when there is none."""
    return take_apart(decompressed(_chunk_record(view, offset)))


def _chunk_record(view: memoryview, offset: int) -> Chunk:
    length = int.from_bytes(view[offset + 1 : offset + RECORD_HEADER], "little")
    begin = offset + RECORD_HEADER
    if view[offset] != Opcode.CHUNK or begin + length > len(view) or not 40 <= length <= LARGEST_RECORD:
        raise ValueError("no chunk")
    (name,) = struct.unpack_from("<I", view, begin + _CHUNK_HEAD)
    if name > 16:
        raise ValueError("no chunk")
    (size,) = struct.unpack_from("<Q", view, begin + _CHUNK_HEAD + 4 + name)
    if _CHUNK_HEAD + 4 + name + 8 + size != length:
        raise ValueError("no chunk: its lengths disagree")
    chunk: Chunk = parse(Chunk, view[begin : begin + length])
    return chunk


def intact_records(view: memoryview) -> IntactRecords:
    """All that is intact in a file.

    Args:
        view: of the file's bytes, which may be mapped.
    """
    found = IntactRecords()
    size = len(view)
    offset = len(MAGIC)
    chunked = _has_chunks(view)
    while offset + RECORD_HEADER <= size:
        end = _take(view, offset, found)
        if end is not None:
            offset = end
            continue
        if _is_end(view, offset):
            break
        _take_declarations(view, offset, found)
        after = _behind_damage(view, offset, chunked)
        found.damages += 1
        found.damaged += after - offset
        offset = after
    _trust_summary(view, found)
    for schema in found.doubtful_schemas:
        if schema.id not in found.schemas and makes_sense(schema):
            found.schemas[schema.id] = schema
    for channel in found.doubtful_channels:
        if (not channel.schema_id or channel.schema_id in found.schemas) and names_a_topic(channel):
            found.channels.setdefault(channel.id, channel)
    return found


def _take_declarations(view: memoryview, offset: int, found: IntactRecords) -> None:
    """Remember what a damaged chunk declares, in case nothing else does."""
    try:
        schemas, channels = declarations(_chunk_record(view, offset))
    except DAMAGE:
        return
    found.doubtful_schemas += schemas
    found.doubtful_channels += channels


def _is_end(view: memoryview, offset: int) -> bool:
    """Whether only the closing bytes of a complete file are left."""
    # Asked at every offset behind a damage: the rest of a large file is not copied for it.
    return len(view) - offset == len(MAGIC) and bytes(view[offset:]) == MAGIC


def _take(view: memoryview, offset: int, found: IntactRecords) -> int | None:
    """Take the record at an offset; returns where it ends, None when it is not intact."""
    opcode = view[offset]
    end = offset + RECORD_HEADER + int.from_bytes(view[offset + 1 : offset + RECORD_HEADER], "little")
    if end > len(view) or (opcode not in _KNOWN and opcode < 0x80):
        return None
    body = view[offset + RECORD_HEADER : end]
    try:
        if opcode == Opcode.CHUNK:
            chunk = _chunk_record(view, offset)
            records = take_apart(decompressed(chunk))
            found.schemas |= {s.id: s for s in records.schemas}
            found.channels |= {c.id: c for c in records.channels}
            found.chunks.append(offset)
            found.compression = chunk.compression or found.compression
        elif opcode == Opcode.MESSAGE:
            raw_message(view[offset:end].tobytes())
            found.loose.append(offset)
        elif opcode == Opcode.SCHEMA:
            (found.index_schemas if found.in_summary else found.doubtful_schemas).append(parse(Schema, body))
        elif opcode == Opcode.CHANNEL:
            (found.index_channels if found.in_summary else found.doubtful_channels).append(parse(Channel, body))
        elif opcode == Opcode.METADATA:
            found.metadata.append(parse(Metadata, body))
        elif opcode == Opcode.ATTACHMENT:
            found.attachments.append(_attachment(body))
        elif not _is_record(view, end):
            return None
        elif opcode == Opcode.DATA_END:
            found.in_summary = True
        elif opcode == Opcode.MESSAGE_INDEX:
            index: MessageIndex = parse(MessageIndex, body)
            found.indexed[index.channel_id] += len(index.records)
    except DAMAGE:
        return None
    return end


def _attachment(body: memoryview) -> Attachment:
    built: Attachment = parse(Attachment, body)
    # Not the last four bytes: the format lets a writer add some behind the checksum.
    end = _ATTACHMENT_HEAD + len(built.name.encode()) + len(built.media_type.encode()) + len(built.data)
    (checksum,) = struct.unpack_from("<I", body, end)
    if checksum and crc32(body[:end]) != checksum:
        raise ValueError("an attachment's checksum is wrong")
    return built


def _is_record(view: memoryview, offset: int) -> bool:
    """Whether a record may begin here: of a known kind, and ending within the file."""
    if offset == len(view) or _is_end(view, offset):
        return True
    if offset + RECORD_HEADER > len(view) or view[offset] not in _KNOWN:
        return False
    return offset + RECORD_HEADER + int.from_bytes(view[offset + 1 : offset + RECORD_HEADER], "little") <= len(view)


def _behind_damage(view: memoryview, offset: int, chunked: bool) -> int:
    """Where reading goes on behind a record that is damaged."""
    size = len(view)
    end = offset + RECORD_HEADER + int.from_bytes(view[offset + 1 : offset + RECORD_HEADER], "little")
    if end < size and _chain(view, end):
        return end
    chunk = _next_chunk(view, offset + 1)
    if chunked:
        return size if chunk is None else chunk
    return next((k for k in _candidates(view, offset + 1, _RECORD) if _chain(view, k)), size)


def _chain(view: memoryview, offset: int, length: int = 4) -> bool:
    """Whether a row of records may begin here."""
    for _ in range(length):
        if offset == len(view) or _is_end(view, offset):
            return True
        if not _is_record(view, offset):
            return False
        offset += RECORD_HEADER + int.from_bytes(view[offset + 1 : offset + RECORD_HEADER], "little")
    return True


def _next_chunk(view: memoryview, offset: int) -> int | None:
    """Where the next intact chunk begins; None when there is none."""
    for place in _candidates(view, offset):
        try:
            chunk_at(view, place)
        except DAMAGE:
            continue
        return place
    return None


def _has_chunks(view: memoryview) -> bool:
    """Whether messages lie in chunks, be they intact or not: then nothing outside of one is taken for a message."""
    for place in _candidates(view, len(MAGIC)):
        try:
            _chunk_record(view, place)
        except DAMAGE:
            continue
        return True
    return False


def _candidates(view: memoryview, offset: int, pattern: re.Pattern[bytes] = _CHUNK) -> Iterator[int]:
    while (match := pattern.search(view, offset)) is not None:
        yield match.start()
        offset = match.start() + 1


def _trust_summary(view: memoryview, found: IntactRecords) -> None:
    """Add declarations of a summary whose checksum is right: the chunk that made them may be damaged."""
    stream = BytesIO(view[-(64 << 20) :] if len(view) > 64 << 20 else view)
    shift = max(0, len(view) - (64 << 20))
    try:
        section = summary_bytes(stream, len(view) - shift) if not shift else None
        if section is None:
            return
        body = section[0]
        for opcode, begin, end in inner_records(body):
            if opcode == Opcode.SCHEMA:
                schema: Schema = parse(Schema, body[begin + RECORD_HEADER : end])
                found.schemas.setdefault(schema.id, schema)
            elif opcode == Opcode.CHANNEL:
                channel: Channel = parse(Channel, body[begin + RECORD_HEADER : end])
                found.channels.setdefault(channel.id, channel)
    except DAMAGE:
        return
