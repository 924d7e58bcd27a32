"""The messages of a file in order of log time, with few of its chunks in memory at once."""

from __future__ import annotations

import heapq
import struct
from collections import OrderedDict
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from typing import BinaryIO, Final

import numpy as np
from mcap.records import Channel, ChunkIndex
from numpy.typing import NDArray

from mbd_bag.formats.chunks import LARGEST_RECORD, RECORD_HEADER, ChunkRecords, RawMessage, raw_message
from mbd_bag.formats.contents import FileContents
from mbd_bag.formats.record_walk import Place, payload

_LOOSE: Final = -1  # in place of a chunk's number: messages that stand outside chunks


@dataclass
class _Rows:
    """The messages of one chunk that are asked for: log times [ns] and places, in order of log time."""

    times: NDArray[np.uint64]
    offsets: NDArray[np.uint64]
    next: int = 0


class OrderedMessages:
    """Merges the chunks of a file, which may overlap in time.

    Args:
        contents: of the file.
        open_chunk: reads one chunk.
        stream: the file, for messages outside chunks.
    """

    def __init__(
        self, contents: FileContents, open_chunk: Callable[[ChunkIndex], ChunkRecords], stream: BinaryIO
    ) -> None:
        self._contents = contents
        self._open_chunk = open_chunk
        self._stream = stream
        self._data: OrderedDict[int, bytes] = OrderedDict()

    def read(self, wanted: Collection[int], start: int | None, end: int | None) -> Iterator[RawMessage]:
        """Messages of these channels, from log time start on and before log time end [ns]; raises one of DAMAGE."""
        chunks = self._contents.chunks
        start = None if start is None else max(start, 0)
        end = None if end is None else max(end, 0)
        waiting = [
            (c.message_start_time, k)
            for k, c in enumerate(chunks)
            if (end is None or c.message_start_time < end)
            and (start is None or c.message_end_time >= start)
            and (not c.message_index_offsets or not c.message_index_offsets.keys().isdisjoint(wanted))
        ]
        waiting.sort(reverse=True)
        if self._contents.loose_offsets:
            waiting.append((0, _LOOSE))
        opened: dict[int, _Rows] = {}
        heap: list[tuple[int, int]] = []
        while waiting or heap:
            while waiting and (not heap or waiting[-1][0] <= heap[0][0]):
                number = waiting.pop()[1]
                rows = self._rows(number, wanted, start, end)
                if len(rows.times):
                    opened[number] = rows
                    heapq.heappush(heap, (int(rows.times[0]), number))
            if not heap:
                continue
            _, number = heap[0]
            rows = opened[number]
            offset = int(rows.offsets[rows.next])
            rows.next += 1
            if rows.next < len(rows.times):
                heapq.heapreplace(heap, (int(rows.times[rows.next]), number))
            else:
                heapq.heappop(heap)
                del opened[number]
            yield self._message(number, offset)
            if number not in opened:
                self._data.pop(number, None)

    def _rows(self, number: int, wanted: Collection[int], start: int | None, end: int | None) -> _Rows:
        if number == _LOOSE:
            times = np.array(self._contents.loose_times, np.uint64)
            offsets = np.array(self._contents.loose_offsets, np.uint64)
            ids = np.array([self._loose_channel(int(o)) for o in offsets], np.uint16)
        else:
            chunk = self._open_chunk(self._contents.chunks[number])
            self._keep(number, chunk.data)
            ids, times = np.array(chunk.ids, np.uint16), np.array(chunk.times, np.uint64)
            offsets = np.array(chunk.offsets, np.uint64)
            # By the declaration in force: one that only another chunk makes is not known to all readers.
            if unknown := set(chunk.ids) - self._contents.channels.keys():
                raise ValueError(f"a message is of channel {min(unknown)}, which is not known")
            self._refuse_other_declarations(chunk.channels)
        taken = np.isin(ids, np.array(sorted(wanted), np.uint16))
        if start is not None:
            taken &= times >= start
        if end is not None:
            taken &= times < end
        times, offsets = times[taken], offsets[taken]
        if np.any(times[1:] < times[:-1]):
            order = np.argsort(times, kind="stable")
            times, offsets = times[order], offsets[order]
        return _Rows(times, offsets)

    def _refuse_other_declarations(self, channels: list[Channel]) -> None:
        for channel in channels:
            known = self._contents.channels.get(channel.id)
            if known is not None and (known.topic, known.schema_id) != (channel.topic, channel.schema_id):
                raise ValueError(f"channel {channel.id} is '{channel.topic}' in a chunk, '{known.topic}' elsewhere")

    def _loose_channel(self, offset: int) -> int:
        self._stream.seek(offset + RECORD_HEADER)
        (channel,) = struct.unpack("<H", self._stream.read(2))
        return int(channel)

    def _keep(self, number: int, data: bytes) -> None:
        self._data[number] = data
        # Chunks that overlap without end are read again rather than kept.
        while len(self._data) > 1 and sum(map(len, self._data.values())) > LARGEST_RECORD:
            self._data.popitem(last=False)

    def _message(self, number: int, offset: int) -> RawMessage:
        if number == _LOOSE:
            self._stream.seek(offset)
            head = self._stream.read(RECORD_HEADER)
            place = Place(head[0], offset, int.from_bytes(head[1:], "little"))
            return raw_message(head + payload(self._stream, place))
        if number not in self._data:
            self._keep(number, self._open_chunk(self._contents.chunks[number]).data)
        return raw_message(self._data[number], offset)
