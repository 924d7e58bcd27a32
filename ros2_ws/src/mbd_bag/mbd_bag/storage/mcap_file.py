"""One MCAP file as far as it is complete: read by its index, or record by record when its writer died.

A writer that is killed leaves a file without summary and footer whose last record may be cut. Everything before that
is good, so such a file is read up to its last complete record; `mcap_completion` can give it the missing end.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path
from typing import BinaryIO

from mcap.opcode import Opcode
from mcap.records import Chunk, ChunkIndex, Header

from mbd_bag.errors import BagError
from mbd_bag.formats.chunks import DAMAGE, ChunkRecords, RawMessage, decompressed, parse, raw_message, take_apart
from mbd_bag.formats.contents import BagMessage, FileContents, FileEnd
from mbd_bag.formats.mcap_scan import scan
from mbd_bag.formats.message_index import check_index
from mbd_bag.formats.message_order import OrderedMessages
from mbd_bag.formats.record_walk import MAGIC, payload, places
from mbd_bag.formats.summary import read_summary

LIBRARY = "mbd_study"  # as our recorders name themselves in a file


class McapFile:
    """One file of a bag.

    Args:
        path: the .mcap file.
        of_ros: refuse one that holds nothing of ROS 2.

    Attributes:
        path: what was opened.
        library: that wrote it.
        contents: what it holds.

    Raises:
        BagError: it is missing, empty, no MCAP file, or not of ROS 2.
    """

    def __init__(self, path: Path, *, of_ros: bool = True) -> None:
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
        encodings = {c.message_encoding for c in self.contents.channels.values()}
        if of_ros and header.profile != "ros2" and "cdr" not in encodings:
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
                    check_index(stream, chunk, self._chunk(stream, chunk))
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
        return found or scan(stream, self.path.name, self._data_start, ours=self.library == LIBRARY)
