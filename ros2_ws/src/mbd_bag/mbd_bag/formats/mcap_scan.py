"""What an MCAP file without a usable summary holds: read record by record, up to the last complete one."""

from __future__ import annotations

from typing import BinaryIO

from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, ChunkIndex, Metadata, MetadataIndex, Schema

from mbd_bag.formats.chunks import DAMAGE, ChunkRecords, decompressed, parse, raw_message, take_apart
from mbd_bag.formats.contents import FileContents, FileEnd
from mbd_bag.formats.message_index import message_index
from mbd_bag.formats.record_walk import MAGIC, Place, payload, places
from mbd_bag.formats.summary import refuse_bomb, summary_agrees

_PRIVATE = 0x80  # from here on kinds of records are other programs' own


def scan(stream: BinaryIO, name: str, start: int, *, ours: bool) -> FileContents:
    """The contents of a file record by record, up to the last complete one.

    Args:
        stream: the file.
        name: of the file, for what is said of it.
        start: where its first record behind the header begins [byte].
        ours: whether our recorder wrote it; others may add records of their own kinds.
    """
    size = stream.seek(0, 2)
    found = FileContents(data_end=start, ends=FileEnd.CUT_OFF)
    indexed: set[int] = set()
    expected: set[int] = set()
    decompressed_size = 0
    closed = False
    for place in places(stream, start, size):
        if place.opcode in (Opcode.DATA_END, Opcode.FOOTER):
            closed, sparse = _summary_kind(stream, place, size)
            if closed and (sparse or summary_agrees(stream, size, found)):
                found.ends = FileEnd.COMPLETE
            break
        try:
            if place.opcode == Opcode.CHUNK:
                chunk: Chunk = parse(Chunk, payload(stream, place))
                decompressed_size += chunk.uncompressed_size
                refuse_bomb(decompressed_size, size)
                expected, indexed = _take(found, take_apart(decompressed(chunk))), set()
                found.chunks.append(_chunk_index(chunk, place))
            elif place.opcode == Opcode.MESSAGE_INDEX:
                index = message_index(stream, place)
                if not found.chunks:
                    raise ValueError("a message index before any chunk")
                indexed.add(index.channel_id)
                found.chunks[-1].message_index_offsets[index.channel_id] = place.offset
                found.chunks[-1].message_index_length += place.end - place.offset
            elif place.opcode == Opcode.METADATA:
                record: Metadata = parse(Metadata, payload(stream, place))
                named = MetadataIndex(offset=place.offset, length=place.end - place.offset, name=record.name)
                found.metadata.append((record, named))
            elif place.opcode in (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE):
                _take_single(found, stream, place)
            elif place.opcode != Opcode.ATTACHMENT and (place.opcode < _PRIVATE or ours):
                raise ValueError(f"a record of kind {place.opcode}, which does not belong there")
        except DAMAGE as error:
            found.ends = FileEnd.DAMAGED
            found.problem = f"{name} is damaged at byte {place.offset} ({error}); read up to there"
            break
        found.data_end = place.end
    if indexed != expected and found.ends is not FileEnd.COMPLETE:
        last = found.chunks[-1]
        last.message_index_offsets.clear()
        last.message_index_length = 0
        found.data_end = last.chunk_start_offset + last.chunk_length
        found.unindexed = True
    if found.ends is FileEnd.CUT_OFF:
        found.problem = _cut_off(name, closed, size - found.data_end)
    return found


def _cut_off(name: str, closed: bool, lost: int) -> str:
    """What is wrong with a file of which so many bytes at its end cannot be read."""
    if closed:
        return f"{name} is damaged in its index; it is read record by record"
    rest = f"all but its last {lost} bytes is read" if lost else "all of it is read"
    return f"{name} is cut off: its recorder was killed; {rest}"


def _summary_kind(stream: BinaryIO, place: Place, size: int) -> tuple[bool, bool]:
    """Whether a file whose data ends at a place is closed by a footer, and whether its summary is a part of one only.

    Chunk indexes and statistics are optional; a file without them is as it was written, if it is closed.
    """
    end = size - len(MAGIC)
    stream.seek(end)
    rest = list(places(stream, place.offset, end)) if stream.read() == MAGIC else []
    closed = bool(rest) and rest[-1].opcode == Opcode.FOOTER and rest[-1].end == end
    return closed, not {Opcode.CHUNK_INDEX, Opcode.STATISTICS} <= {p.opcode for p in rest}


def _take(found: FileContents, chunk: ChunkRecords) -> set[int]:
    """Add what a chunk holds to the contents found so far; returns the channels of its messages.

    Raises:
        ValueError: a message is of a channel that was declared in a place that is damaged; then nothing is added.
    """
    used = set(chunk.ids)
    if unknown := used - set(found.channels) - {c.id for c in chunk.channels}:
        raise ValueError(f"a message is of channel {min(unknown)}, which is not known")
    found.schemas |= {s.id: s for s in chunk.schemas}
    found.channels |= {c.id: c for c in chunk.channels}
    for channel, log_time in zip(chunk.ids, chunk.times, strict=True):
        found.count_message(channel, log_time)
    return used


def _take_single(found: FileContents, stream: BinaryIO, place: Place) -> None:
    """Add a schema, channel or message that stands outside a chunk; raises as `_take`."""
    data = payload(stream, place)
    if place.opcode == Opcode.SCHEMA:
        schema: Schema = parse(Schema, data)
        found.schemas[schema.id] = schema
        return
    if place.opcode == Opcode.CHANNEL:
        channel: Channel = parse(Channel, data)
        found.channels[channel.id] = channel
        return
    message = raw_message(bytes([place.opcode]) + place.length.to_bytes(8, "little") + data)
    if message.channel not in found.channels:
        raise ValueError(f"a message is of channel {message.channel}, which is not known")
    found.count_message(message.channel, message.log_time)
    found.loose_times.append(message.log_time)
    found.loose_offsets.append(place.offset)


def _chunk_index(chunk: Chunk, place: Place) -> ChunkIndex:
    return ChunkIndex(
        message_start_time=chunk.message_start_time,
        message_end_time=chunk.message_end_time,
        chunk_start_offset=place.offset,
        chunk_length=place.end - place.offset,
        message_index_offsets={},
        message_index_length=0,
        compression=chunk.compression,
        compressed_size=len(chunk.data),
        uncompressed_size=chunk.uncompressed_size,
    )
