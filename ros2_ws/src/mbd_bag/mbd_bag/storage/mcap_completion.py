"""Give a file whose writer died the summary and footer it lacks, in place, so that every MCAP reader takes it."""

from __future__ import annotations

import os
import struct
from collections import defaultdict
from pathlib import Path
from typing import BinaryIO
from zlib import crc32

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Chunk, DataEnd, Footer, MessageIndex, Statistics

from mbd_bag.errors import BagError
from mbd_bag.formats.chunks import decompressed, parse, take_apart
from mbd_bag.formats.contents import FileContents, FileEnd
from mbd_bag.formats.record_walk import MAGIC
from mbd_bag.storage.mcap_file import McapFile


def complete(path: Path) -> McapFile:
    """Cut the file behind its last complete record, write message indexes, summary and footer there, and read it again.

    Killed on the way, it leaves a file that can be completed once more. A complete file is left alone.

    Args:
        path: a file that no recorder writes any more.

    Raises:
        BagError: the file cannot be read at all, or is damaged rather than cut off.
    """
    file = McapFile(path)
    if file.complete:
        return file
    contents = file.contents
    if contents.ends is FileEnd.DAMAGED:
        raise BagError(f"{contents.problem}. It is not completed: `repair` it, and record into another bag")
    with path.open("r+b") as stream:
        if contents.unindexed:
            _index_last_chunk(stream, contents)
        stream.truncate(contents.data_end)
        stream.seek(contents.data_end)
        stream.write(_ending(contents))
        stream.flush()
        os.fsync(stream.fileno())
    return McapFile(path)


def _index_last_chunk(stream: BinaryIO, contents: FileContents) -> None:
    """Write the message indexes of the last chunk behind it."""
    last = contents.chunks[-1]
    stream.seek(last.chunk_start_offset + 9)
    found = take_apart(decompressed(parse(Chunk, stream.read(last.chunk_length - 9))))
    indexes: dict[int, MessageIndex] = {}
    for channel_id, log_time, start in zip(found.ids, found.times, found.offsets, strict=True):
        indexes.setdefault(channel_id, MessageIndex(channel_id=channel_id, records=[])).records.append(
            (log_time, start)
        )
    stream.seek(contents.data_end)
    for channel_id, index in indexes.items():
        builder = RecordBuilder()
        index.write(builder)
        last.message_index_offsets[channel_id] = contents.data_end
        block = builder.end()
        stream.write(block)
        contents.data_end += len(block)
        last.message_index_length += len(block)


def _ending(contents: FileContents) -> bytes:
    """DataEnd, summary section, footer and magic of a file whose data section ends at ``contents.data_end``."""
    head = RecordBuilder()
    DataEnd(0).write(head)
    data_end_record = head.end()
    summary = RecordBuilder()
    for schema in contents.schemas.values():
        schema.write(summary)
    for channel in contents.channels.values():
        channel.write(summary)
    Statistics(
        attachment_count=0,
        channel_count=len(contents.channels),
        channel_message_counts=defaultdict(int, contents.counts),
        chunk_count=len(contents.chunks),
        message_count=sum(contents.counts.values()),
        metadata_count=len(contents.metadata),
        message_start_time=contents.start,
        message_end_time=contents.end,
        schema_count=len(contents.schemas),
    ).write(summary)
    for chunk in contents.chunks:
        chunk.write(summary)
    for _, place in contents.metadata:
        if place is not None:  # known of every record of a file that had to be scanned, as one that is not complete
            place.write(summary)
    body = summary.end()
    summary_start = contents.data_end + len(data_end_record)
    checksum = crc32(struct.pack("<BQQQ", Opcode.FOOTER, 8 + 8 + 4, summary_start, 0), crc32(body))
    foot = RecordBuilder()
    Footer(summary_start=summary_start, summary_offset_start=0, summary_crc=checksum).write(foot)
    return bytes(data_end_record) + bytes(body) + bytes(foot.end()) + MAGIC
