"""The message indexes behind a chunk: optional, and right or wrong."""

from __future__ import annotations

from typing import BinaryIO

from mcap.opcode import Opcode
from mcap.records import ChunkIndex, MessageIndex

from mbd_bag.formats.chunks import ChunkRecords, parse
from mbd_bag.formats.record_walk import Place, payload, places

_HEAD, _ENTRY = 6, 16  # [byte]


def message_index(stream: BinaryIO, place: Place) -> MessageIndex:
    """A message index; raises one of DAMAGE when its size is not that of its entries.

    The format lets a writer add bytes to a record; more of them than an entry has are entries that were lost.
    """
    index: MessageIndex = parse(MessageIndex, payload(stream, place))
    if not 0 <= place.length - _HEAD - _ENTRY * len(index.records) < _ENTRY:
        raise ValueError("a message index has another size than its entries")
    return index


def check_index(stream: BinaryIO, index: ChunkIndex, chunk: ChunkRecords) -> None:
    """Raises ValueError when the message indexes of a chunk do not lead to its messages."""
    if not index.message_index_offsets:
        return  # they are optional
    listed: set[tuple[int, int, int]] = set()
    for channel, offset in index.message_index_offsets.items():
        end = index.chunk_start_offset + index.chunk_length + index.message_index_length
        place = next(places(stream, offset, end), None)
        if place is None or place.opcode != Opcode.MESSAGE_INDEX:
            raise ValueError(f"there is no message index at byte {offset}")
        record = message_index(stream, place)
        listed |= {(record.channel_id, time, start) for time, start in record.records}
        if record.channel_id != channel:
            raise ValueError(f"the message index at byte {offset} is of another channel")
    if listed != set(zip(chunk.ids, chunk.times, chunk.offsets, strict=True)):
        raise ValueError(f"the message index of the chunk at byte {index.chunk_start_offset} is not of its messages")
