"""One MCAP file as far as it is complete: read by its index, or record by record when its writer died.

A writer that is killed leaves a file without summary and footer whose last record may be cut. Everything before that
is good, so such a file is read up to its last complete record; `mcap_completion` can give it the missing end.
"""

from __future__ import annotations

import struct
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from enum import Enum
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import SeekingReader
from mcap.records import Channel, Chunk, ChunkIndex, Header, Message, MessageIndex, Metadata, MetadataIndex, Schema
from mcap.stream_reader import breakup_chunk

from mbd_bag.errors import BagError

MAGIC = b"\x89MCAP0\r\n"
_RECORD_HEADER = 9  # opcode and length
# What the mcap library and the decompressors raise on bytes that are not what they should be.
# A length with a flipped bit asks for more memory than there is.
_DAMAGE = (
    McapError,
    struct.error,
    RuntimeError,
    ValueError,
    KeyError,
    OverflowError,
    MemoryError,
    zstandard.ZstdError,
)


@dataclass(frozen=True)
class BagMessage:
    """One recorded message, still serialized.

    Attributes:
        topic: absolute name.
        msgtype: ``package/msg/Type``.
        log_time: when it was received [ns].
        publish_time: when it was published [ns].
        data: its CDR bytes.
    """

    topic: str
    msgtype: str
    log_time: int
    publish_time: int
    data: bytes


class FileEnd(Enum):
    """How a file ends: with its summary; where its writer died; or before bytes that cannot be read."""

    COMPLETE = "complete"
    CUT_OFF = "cut off"
    DAMAGED = "damaged"


@dataclass
class FileContents:
    """What a file holds, found without keeping its messages.

    Attributes:
        schemas, channels: records by id.
        counts: messages by channel id.
        start, end: log times of the first and last message [ns]; 0 when there is none.
        metadata: metadata records in file order, with their indexes where the file had to be scanned.
        chunks: index of each chunk, in file order.
        data_end: offset behind the last complete record of the data section [byte].
        unindexed: True when the last chunk lacks some of its message indexes; ``data_end`` is then that chunk's end.
        ends: how the file ends.
        problem: why it is not complete, one sentence for people; "" when it is.
    """

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    counts: dict[int, int] = field(default_factory=dict)
    start: int = 0
    end: int = 0
    metadata: list[tuple[Metadata, MetadataIndex | None]] = field(default_factory=list)
    chunks: list[ChunkIndex] = field(default_factory=list)
    data_end: int = 0
    unindexed: bool = False
    ends: FileEnd = FileEnd.COMPLETE
    problem: str = ""

    def topic_counts(self) -> dict[str, int]:
        """Messages by topic."""
        counts: dict[str, int] = {}
        for channel_id, channel in self.channels.items():
            counts[channel.topic] = counts.get(channel.topic, 0) + self.counts.get(channel_id, 0)
        return counts


def _complete_records(stream: BinaryIO, size: int) -> Iterator[tuple[int, int, bytes]]:
    """(opcode, offset, payload) of each record that is not cut, from the present position on."""
    offset = stream.tell()
    while offset + _RECORD_HEADER <= size:
        opcode, length = struct.unpack("<BQ", stream.read(_RECORD_HEADER))
        if offset + _RECORD_HEADER + length > size:
            return
        yield opcode, offset, stream.read(length)
        offset += _RECORD_HEADER + length


def _parse(record: Any, payload: bytes) -> Any:
    return record.read(ReadDataStream(BytesIO(payload)))


class McapFile:
    """One file of a bag.

    Args:
        path: the .mcap file.

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
            first = next(_complete_records(stream, size), None)
            if first is None or first[0] != Opcode.HEADER:
                raise BagError(f"{path} is cut off right after its start ({size} bytes); nothing can be read")
            try:
                header: Header = _parse(Header, first[2])
            except _DAMAGE as error:
                raise BagError(f"{path} is damaged in its first bytes ({error}); nothing can be read") from error
            if header.profile != "ros2":
                raise BagError(
                    f"{path} was written by '{header.library}' with profile '{header.profile}'; "
                    f"expected a ROS 2 bag (profile 'ros2')"
                )
            self._data_start = stream.tell()
        self.library: str = header.library
        self.contents = self._read_index() or self._scan()

    @property
    def complete(self) -> bool:
        """True when the file has its summary and footer."""
        return self.contents.ends is FileEnd.COMPLETE

    def messages(
        self, topics: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[BagMessage]:
        """Messages in order of log time; a cut-off file's in the order written.

        Args:
            topics: only of these; None: of all.
            start: only from this log time on [ns].
            end: only before this log time [ns].
        """
        with self.path.open("rb") as stream:
            if self.complete:
                reader = SeekingReader(stream, validate_crcs=True)
                try:
                    for found in reader.iter_messages(topics, starting_at=start, ending_before=end):
                        yield _bag_message(*found)
                except _DAMAGE as error:
                    raise BagError(
                        f"{self.path} is damaged ({error}); `repair` saves what stands before that"
                    ) from error
            else:
                channels, schemas = self.contents.channels, self.contents.schemas
                for message in self._scanned_messages(stream):
                    channel = channels[message.channel_id]
                    early = start is not None and message.log_time < start
                    late = end is not None and message.log_time >= end
                    if not early and not late and (topics is None or channel.topic in topics):
                        yield _bag_message(schemas.get(channel.schema_id), channel, message)

    def _read_index(self) -> FileContents | None:
        """The contents by the summary section; None when there is none (or only a part of it)."""
        with self.path.open("rb") as stream:
            try:
                reader = SeekingReader(stream)
                summary = reader.get_summary()
                if summary is None or summary.statistics is None:
                    return None
                metadata: list[tuple[Metadata, MetadataIndex | None]] = [(m, None) for m in reader.iter_metadata()]
            except (*_DAMAGE, OSError):
                return None
        statistics = summary.statistics
        return FileContents(
            schemas=dict(summary.schemas),
            channels=dict(summary.channels),
            counts=dict(statistics.channel_message_counts),
            start=statistics.message_start_time,
            end=statistics.message_end_time,
            metadata=metadata,
            chunks=list(summary.chunk_indexes),
        )

    def _scan(self) -> FileContents:
        """The contents record by record, up to the last complete one."""
        found = FileContents(data_end=self._data_start, ends=FileEnd.CUT_OFF)
        indexed: set[int] = set()
        expected: set[int] = set()
        with self.path.open("rb") as stream:
            stream.seek(self._data_start)
            for opcode, offset, payload in _complete_records(stream, self.path.stat().st_size):
                after = offset + _RECORD_HEADER + len(payload)
                if opcode in (Opcode.DATA_END, Opcode.FOOTER):
                    break
                try:
                    if opcode == Opcode.CHUNK:
                        chunk: Chunk = _parse(Chunk, payload)
                        records = breakup_chunk(chunk, validate_crc=True)
                        used = _take(found, records)
                        expected, indexed = used, set()
                        found.chunks.append(_chunk_index(chunk, offset, after - offset))
                    elif opcode == Opcode.MESSAGE_INDEX and found.chunks:
                        index: MessageIndex = _parse(MessageIndex, payload)
                        indexed.add(index.channel_id)
                        found.chunks[-1].message_index_offsets[index.channel_id] = offset
                        found.chunks[-1].message_index_length += after - offset
                    elif opcode == Opcode.METADATA:
                        record: Metadata = _parse(Metadata, payload)
                        place = MetadataIndex(offset=offset, length=after - offset, name=record.name)
                        found.metadata.append((record, place))
                    elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE):
                        _take(found, [_single(opcode, payload)])
                except _DAMAGE as error:
                    found.ends = FileEnd.DAMAGED
                    found.problem = f"{self.path.name} is damaged at byte {offset} ({error}); read up to there"
                    break
                found.data_end = after
        if indexed != expected:
            last = found.chunks[-1]
            last.message_index_offsets.clear()
            last.message_index_length = 0
            found.data_end = last.chunk_start_offset + last.chunk_length
            found.unindexed = True
        if found.ends is FileEnd.CUT_OFF:
            lost = self.path.stat().st_size - found.data_end
            rest = f"all but its last {lost} bytes is read" if lost else "all of it is read"
            found.problem = f"{self.path.name} is cut off: its recorder was killed; {rest}"
        return found

    def _scanned_messages(self, stream: BinaryIO) -> Iterator[Message]:
        stream.seek(self._data_start)
        for opcode, _, payload in _complete_records(stream, self.contents.data_end):
            if opcode == Opcode.CHUNK:
                yield from (r for r in breakup_chunk(_parse(Chunk, payload)) if isinstance(r, Message))
            elif opcode == Opcode.MESSAGE:
                yield _single(opcode, payload)


def _single(opcode: int, payload: bytes) -> Any:
    """A schema, channel or message record that stands outside a chunk."""
    stream = ReadDataStream(BytesIO(payload))
    if opcode == Opcode.MESSAGE:
        return Message.read(stream, len(payload))
    return Schema.read(stream) if opcode == Opcode.SCHEMA else Channel.read(stream)


def _take(found: FileContents, records: list[Any]) -> set[int]:
    """Add what these records hold to the contents found so far; returns the channels of their messages.

    Raises:
        ValueError: a message is of a channel that was declared in a place that is damaged; then nothing is added.
    """
    used = {r.channel_id for r in records if isinstance(r, Message)}
    if unknown := used - set(found.channels) - {r.id for r in records if isinstance(r, Channel)}:
        raise ValueError(f"a message is of channel {min(unknown)}, which is not known")
    for record in records:
        if isinstance(record, Schema):
            found.schemas[record.id] = record
        elif isinstance(record, Channel):
            found.channels[record.id] = record
        elif isinstance(record, Message):
            first = not found.counts
            found.counts[record.channel_id] = found.counts.get(record.channel_id, 0) + 1
            found.start = record.log_time if first else min(found.start, record.log_time)
            found.end = max(found.end, record.log_time)
    return used


def _chunk_index(chunk: Chunk, offset: int, length: int) -> ChunkIndex:
    return ChunkIndex(
        message_start_time=chunk.message_start_time,
        message_end_time=chunk.message_end_time,
        chunk_start_offset=offset,
        chunk_length=length,
        message_index_offsets={},
        message_index_length=0,
        compression=chunk.compression,
        compressed_size=len(chunk.data),
        uncompressed_size=chunk.uncompressed_size,
    )


def _bag_message(schema: Schema | None, channel: Channel, message: Message) -> BagMessage:
    return BagMessage(
        topic=channel.topic,
        msgtype=schema.name if schema is not None else "",
        log_time=message.log_time,
        publish_time=message.publish_time,
        data=message.data,
    )
