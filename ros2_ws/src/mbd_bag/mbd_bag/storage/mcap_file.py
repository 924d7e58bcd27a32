"""One MCAP file as far as it is complete: read by its index, or record by record when its writer died.

A writer that is killed leaves a file without summary and footer whose last record may be cut. Everything before that
is good, so such a file is read up to its last complete record; `mcap_completion` can give it the missing end.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path
from typing import BinaryIO

from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, ChunkIndex, Header, MessageIndex, Metadata, MetadataIndex, Schema

from mbd_bag.errors import BagError
from mbd_bag.formats.chunks import DAMAGE, ChunkRecords, RawMessage, decompressed, parse, raw_message, take_apart
from mbd_bag.formats.contents import BagMessage, FileContents, FileEnd
from mbd_bag.formats.message_order import OrderedMessages
from mbd_bag.formats.record_walk import MAGIC, Place, payload, places
from mbd_bag.formats.summary import read_summary, refuse_bomb

LIBRARY = "mbd_study"  # as our recorders name themselves in a file
_PRIVATE = 0x80  # from here on kinds of records are other programs' own


class McapFile:
    """One file of a bag.

    Args:
        path: the .mcap file.

    Attributes:
        path: what was opened.
        library: that wrote it.
        contents: what it holds.

    Raises:
        BagError: it is missing, empty, no MCAP file, or not of ROS 2.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        if not path.is_file():
            raise BagError(f"{path} is missing; the bag's metadata.yaml names it. Put it back beside the others")
        size = path.stat().st_size
        if size == 0:
            raise BagError(
                f"{path} is empty (0 bytes): its recorder died before it wrote anything; nothing can be read"
            )
        with path.open("rb") as stream:
            if stream.read(len(MAGIC)) != MAGIC:
                raise BagError(f"{path} is no MCAP file (wrong first bytes); expected a bag recorded by `recorder`")
            first = next(places(stream, len(MAGIC), size), None)
            if first is None or first.opcode != Opcode.HEADER:
                raise BagError(f"{path} is cut off right after its start ({size} bytes); nothing can be read")
            try:
                header: Header = parse(Header, payload(stream, first))
            except DAMAGE as error:
                raise BagError(f"{path} is damaged in its first bytes ({error}); nothing can be read") from error
            self._data_start = first.end
            self.library: str = header.library
            self.contents = self._contents(stream, size)
        # Writers other than ROS's own leave the profile empty, and still write its messages.
        if header.profile != "ros2" and not any(c.message_encoding == "cdr" for c in self.contents.channels.values()):
            raise BagError(
                f"{path} was written by '{header.library}' with profile '{header.profile}'; "
                f"expected a ROS 2 bag (profile 'ros2')"
            )

    @property
    def complete(self) -> bool:
        """True when the file has its summary and footer."""
        return self.contents.ends is FileEnd.COMPLETE

    def messages(
        self, topics: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[BagMessage]:
        """Messages in order of log time.

        Args:
            topics: only of these; None: of all.
            start: only from this log time on [ns].
            end: only before this log time [ns].

        Raises:
            BagError: the file is damaged, or, where it is read from end to end, holds other messages than its index
                counts.
        """
        contents = self.contents
        wanted = {k for k, c in contents.channels.items() if topics is None or c.topic in topics}
        read = dict.fromkeys(wanted, 0)
        with self.path.open("rb") as stream:
            source = OrderedMessages(contents, lambda index: self._chunk(stream, index), stream)
            try:
                for raw in source.read(wanted, start, end):
                    read[raw.channel] += 1
                    yield self._named(raw)
            except DAMAGE as error:
                raise BagError(f"{self.path} is damaged ({error}); `repair` saves all that is intact") from error
        if start is None and end is None:
            self._refuse_other_count(read)

    def _refuse_other_count(self, read: dict[int, int]) -> None:
        counted = {k: self.contents.counts.get(k, 0) for k in read}
        if read != counted:
            topics = sorted({self.contents.channels[k].topic for k in read if read[k] != counted[k]})
            raise BagError(
                f"{self.path} holds {sum(read.values())} messages where its index counts {sum(counted.values())} "
                f"(on {', '.join(topics[:3])}{', ...' if len(topics) > 3 else ''}): "
                f"{abs(sum(counted.values()) - sum(read.values()))} are missing or not listed. `repair` makes a copy "
                f"that counts what is there"
            )

    def chunk_messages(self, index: ChunkIndex) -> Iterator[BagMessage]:
        """The messages of one chunk in the order written; raises one of DAMAGE when it is not intact."""
        with self.path.open("rb") as stream:
            chunk = self._chunk(stream, index)
        yield from (self._named(raw_message(chunk.data, offset)) for offset in chunk.offsets)

    def _named(self, raw: RawMessage) -> BagMessage:
        channel = self.contents.channels[raw.channel]
        schema = self.contents.schemas.get(channel.schema_id)
        kind = schema.name if schema is not None else ""
        return BagMessage(channel.topic, kind, raw.log_time, raw.publish_time, raw.data)

    def check(self) -> str:
        """Read all of the file; returns what is wrong with it, one sentence, "" when nothing is.

        Also what only other readers would notice: an index that does not lead to its messages.
        """
        try:
            for _ in self.messages():
                pass
            with self.path.open("rb") as stream:
                for chunk in self.contents.chunks:
                    _check_index(stream, chunk, self._chunk(stream, chunk))
        except BagError as error:
            return str(error)
        except DAMAGE as error:
            return f"{self.path} is damaged ({error}); `repair` saves all that is intact"
        return self.contents.problem

    def _chunk(self, stream: BinaryIO, index: ChunkIndex) -> ChunkRecords:
        stream.seek(index.chunk_start_offset)
        place = next(places(stream, index.chunk_start_offset, index.chunk_start_offset + index.chunk_length), None)
        if place is None or place.opcode != Opcode.CHUNK:
            raise ValueError(f"there is no chunk at byte {index.chunk_start_offset}, where the index has one")
        chunk: Chunk = parse(Chunk, payload(stream, place))
        if chunk.uncompressed_size != index.uncompressed_size:
            raise ValueError(f"the chunk at byte {place.offset} has another size than in the index")
        return take_apart(decompressed(chunk))

    def _contents(self, stream: BinaryIO, size: int) -> FileContents:
        try:
            found = read_summary(stream, size)
        except DAMAGE as error:
            if "decompress" in str(error):
                raise BagError(f"{self.path} is refused: {error}") from error
            found = None
        return found or self._scan(stream, size)

    def _scan(self, stream: BinaryIO, size: int) -> FileContents:
        """The contents record by record, up to the last complete one."""
        found = FileContents(data_end=self._data_start, ends=FileEnd.CUT_OFF)
        indexed: set[int] = set()
        expected: set[int] = set()
        decompressed_size = 0
        closed = False
        for place in places(stream, self._data_start, size):
            if place.opcode in (Opcode.DATA_END, Opcode.FOOTER):
                closed, sparse = _summary_kind(stream, place, size)
                found.ends = FileEnd.COMPLETE if closed and sparse else FileEnd.CUT_OFF
                break
            try:
                if place.opcode == Opcode.CHUNK:
                    chunk: Chunk = parse(Chunk, payload(stream, place))
                    decompressed_size += chunk.uncompressed_size
                    refuse_bomb(decompressed_size, size)
                    expected, indexed = _take(found, take_apart(decompressed(chunk))), set()
                    found.chunks.append(_chunk_index(chunk, place))
                elif place.opcode == Opcode.MESSAGE_INDEX:
                    index = _message_index(stream, place)
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
                elif place.opcode != Opcode.ATTACHMENT and (place.opcode < _PRIVATE or self.library == LIBRARY):
                    raise ValueError(f"a record of kind {place.opcode}, which does not belong there")
            except DAMAGE as error:
                found.ends = FileEnd.DAMAGED
                found.problem = f"{self.path.name} is damaged at byte {place.offset} ({error}); read up to there"
                break
            found.data_end = place.end
        if indexed != expected and found.ends is not FileEnd.COMPLETE:
            last = found.chunks[-1]
            last.message_index_offsets.clear()
            last.message_index_length = 0
            found.data_end = last.chunk_start_offset + last.chunk_length
            found.unindexed = True
        if found.ends is FileEnd.CUT_OFF and closed:
            found.problem = f"{self.path.name} is damaged in its index; it is read record by record"
        elif found.ends is FileEnd.CUT_OFF:
            lost = size - found.data_end
            rest = f"all but its last {lost} bytes is read" if lost else "all of it is read"
            found.problem = f"{self.path.name} is cut off: its recorder was killed; {rest}"
        return found


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


def _message_index(stream: BinaryIO, place: Place) -> MessageIndex:
    """A message index; raises one of DAMAGE when its size is not that of its entries."""
    index: MessageIndex = parse(MessageIndex, payload(stream, place))
    if place.length != 6 + 16 * len(index.records):
        raise ValueError("a message index has another size than its entries")
    return index


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


def _check_index(stream: BinaryIO, index: ChunkIndex, chunk: ChunkRecords) -> None:
    """Raises ValueError when the message indexes of a chunk do not lead to its messages."""
    if not index.message_index_offsets:
        return  # they are optional
    listed: set[tuple[int, int, int]] = set()
    for channel, offset in index.message_index_offsets.items():
        end = index.chunk_start_offset + index.chunk_length + index.message_index_length
        place = next(places(stream, offset, end), None)
        if place is None or place.opcode != Opcode.MESSAGE_INDEX:
            raise ValueError(f"there is no message index at byte {offset}")
        record = _message_index(stream, place)
        listed |= {(record.channel_id, time, start) for time, start in record.records}
        if record.channel_id != channel:
            raise ValueError(f"the message index at byte {offset} is of another channel")
    if listed != set(zip(chunk.ids, chunk.times, chunk.offsets, strict=True)):
        raise ValueError(f"the message index of the chunk at byte {index.chunk_start_offset} is not of its messages")


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
