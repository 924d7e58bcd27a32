"""Read a bag: a rosbag2 folder of MCAP or sqlite3 files, compressed or not, or one such file, finished or cut off."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mbd_bag.errors import BagError
from mbd_bag.formats.bag_file import BagFile
from mbd_bag.formats.contents import BagMessage
from mbd_bag.formats.opening import open_bag
from mbd_bag.storage.bag_metadata import FILE_NAME, read_metadata
from mbd_bag.storage.decoding import Decoder
from mbd_bag.storage.finishing import FACTS_RECORD
from mbd_bag.storage.topic_qos import TopicQos, from_yaml


@dataclass(frozen=True)
class TopicSummary:
    """One topic of a bag: absolute name, type, number of messages."""

    name: str
    msgtype: str
    count: int


class Bag:
    """A bag opened for reading; nothing in it is changed.

    Args:
        path: the bag's folder, or one of its files.

    Attributes:
        path: what was opened.
        files: its files in the order recorded.
        facts: what is true of the complete session, see `session_facts`.
        problems: what is missing from it, one sentence each; () for a bag that was closed properly.
        notes: those of the problems that are no damage.

    Raises:
        BagError: there is no bag, it is empty, or of another kind.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        problems: list[str] = []
        metadata = read_metadata(path) if (path / FILE_NAME).exists() else None
        # Keeps what was unpacked as long as the bag.
        self._opened = open_bag(path, metadata, problems)
        self.files: tuple[BagFile, ...] = self._opened.files
        problems += [f.contents.problem for f in self.files if f.contents.problem]
        self.notes = tuple(dict.fromkeys(f.contents.note for f in self.files if f.contents.note))
        if metadata is not None and metadata["message_count"] not in (-1, self.message_count):
            problems.append(
                f"{FILE_NAME} counts {metadata['message_count']} messages, its files hold {self.message_count}"
            )
        self.problems = (*problems, *self.notes)
        self.facts: dict[str, str] = {}
        for file in self.files:
            for record, _ in file.contents.metadata:
                if record.name == FACTS_RECORD:
                    self.facts |= record.metadata
        if metadata is not None:
            # Added to the bag after it was finished: that another one took its place.
            self.facts |= metadata["custom_data"]
        if not self.message_count:
            raise BagError(f"{path} holds no message; expected a recorded session")
        self._decoder: Decoder | None = None

    @property
    def message_count(self) -> int:
        """Messages on all topics."""
        return sum(sum(f.contents.counts.values()) for f in self.files)

    @property
    def start(self) -> int:
        """Log time of the first message [ns]."""
        return min(f.contents.start for f in self.files if f.contents.counts)

    @property
    def end(self) -> int:
        """Log time of the last message [ns]."""
        return max(f.contents.end for f in self.files if f.contents.counts)

    @property
    def topics(self) -> tuple[TopicSummary, ...]:
        """Every topic by name."""
        types: dict[str, str] = {}
        counts: dict[str, int] = {}
        for file in self.files:
            for channel in file.contents.channels.values():
                schema = file.contents.schemas.get(channel.schema_id)
                types[channel.topic] = schema.name if schema is not None else ""
            for topic, count in file.contents.topic_counts().items():
                counts[topic] = counts.get(topic, 0) + count
        return tuple(TopicSummary(name, types[name], counts[name]) for name in sorted(types))

    def offered_qos(self, topic: str) -> tuple[TopicQos, ...]:
        """The profiles with which a topic was published; () when the bag does not state."""
        channels = (c for f in self.files for c in f.contents.channels.values() if c.topic == topic)
        return next((from_yaml(c.metadata.get("offered_qos_profiles", "")) for c in channels), ())

    def check(self) -> tuple[str, ...]:
        """Read all of it; returns what is wrong with it, `problems` and what only shows in its messages."""
        found = (file.check() for file in self.files)
        return tuple(dict.fromkeys((*self.problems, *(problem for problem in found if problem))))

    @property
    def decoder(self) -> Decoder:
        """Decodes this bag's messages; raises BagError when its files disagree on a type."""
        if self._decoder is None:
            self._decoder = Decoder(s for f in self.files for s in f.contents.schemas.values())
        return self._decoder

    def messages(
        self, topics: Collection[str] | None = None, start: int | None = None, end: int | None = None
    ) -> Iterator[BagMessage]:
        """Serialized messages in the order of log time, file after file.

        Args:
            topics: only of these; None: of all.
            start: only from this log time on [ns].
            end: only before this log time [ns].
        """
        for file in self.files:
            yield from file.messages(topics, start, end)

    def decoded(self, topics: Collection[str] | None = None) -> Iterator[tuple[BagMessage, Any]]:
        """Messages of these topics with their decoded objects; raises BagError for one that cannot be decoded."""
        for file in self.files:
            for channel in file.contents.channels.values():
                if channel.message_encoding != "cdr" and (topics is None or channel.topic in topics):
                    raise BagError(
                        f"topic {channel.topic} of {file.path} is serialized as '{channel.message_encoding}'; expected "
                        f"'cdr', as ROS 2's own middleware writes it"
                    )
        for message in self.messages(topics):
            yield message, self.decoder.decode(message)
