"""What a file of a bag holds, whatever its format."""

from __future__ import annotations

from array import array
from dataclasses import dataclass, field
from enum import Enum

from mcap.records import Channel, ChunkIndex, Metadata, MetadataIndex, Schema


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
        loose_times, loose_offsets: log time [ns] and place [byte] of each message outside chunks, in file order.
        data_end: offset behind the last complete record of the data section [byte].
        unindexed: True when the last chunk lacks some of its message indexes; ``data_end`` is then that chunk's end.
        ends: how the file ends.
        problem: why it is not complete, one sentence for people; "" when it is.
        note: what is to be known of a complete one, one sentence for people; "" for nothing.
    """

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    counts: dict[int, int] = field(default_factory=dict)
    start: int = 0
    end: int = 0
    metadata: list[tuple[Metadata, MetadataIndex | None]] = field(default_factory=list)
    chunks: list[ChunkIndex] = field(default_factory=list)
    loose_times: array[int] = field(default_factory=lambda: array("Q"))
    loose_offsets: array[int] = field(default_factory=lambda: array("Q"))
    data_end: int = 0
    unindexed: bool = False
    ends: FileEnd = FileEnd.COMPLETE
    problem: str = ""
    note: str = ""

    @property
    def message_count(self) -> int:
        """Messages of all channels."""
        return sum(self.counts.values())

    def count_message(self, channel: int, log_time: int) -> None:
        """Count one message of a channel, logged at this time [ns]."""
        self.start = min(self.start, log_time) if self.counts else log_time
        self.counts[channel] = self.counts.get(channel, 0) + 1
        self.end = max(self.end, log_time)

    def topic_counts(self) -> dict[str, int]:
        """Messages by topic."""
        counts: dict[str, int] = {}
        for channel_id, channel in self.channels.items():
            counts[channel.topic] = counts.get(channel.topic, 0) + self.counts.get(channel_id, 0)
        return counts
