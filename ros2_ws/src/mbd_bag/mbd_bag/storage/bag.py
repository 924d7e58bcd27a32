"""Read a session bag: a rosbag2 folder or a single .mcap file, finished or cut off."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mbd_bag.errors import BagError
from mbd_bag.storage.bag_metadata import FILE_NAME, read_metadata
from mbd_bag.storage.bag_writer import FACTS_RECORD
from mbd_bag.storage.decoding import Decoder
from mbd_bag.storage.mcap_file import BagMessage, McapFile
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
        path: the bag's folder, or one .mcap file.

    Attributes:
        path: what was opened.
        files: its files in the order recorded.
        facts: what is true of the complete session, see `session_facts`.
        problems: what is missing from it, one sentence each; () for a bag that was closed properly.

    Raises:
        BagError: there is no bag, it is empty, or of another kind.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        problems: list[str] = []
        metadata = read_metadata(path) if (path / FILE_NAME).exists() else None
        self.files = tuple(_open(path, metadata, problems))
        problems += [f.contents.problem for f in self.files if f.contents.problem]
        self.problems = tuple(problems)
        self.facts: dict[str, str] = {}
        for file in self.files:
            for record, _ in file.contents.metadata:
                if record.name == FACTS_RECORD:
                    self.facts |= record.metadata
        if metadata is not None:
            # Added to the bag after it was finished: that another one took its place.
            self.facts |= {k: str(v) for k, v in (metadata.get("custom_data") or {}).items()}
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
        for message in self.messages(topics):
            yield message, self.decoder.decode(message)


def _open(path: Path, metadata: dict[str, Any] | None, problems: list[str]) -> Iterator[McapFile]:
    """The files of a bag; states in ``problems`` what is missing."""
    if not path.exists():
        raise BagError(f"there is no bag {path}; give the folder a `recorder` wrote, or one .mcap file")
    if path.is_file():
        yield McapFile(path)
        return
    if metadata is not None:
        for name in metadata["relative_file_paths"]:
            yield McapFile(path / Path(str(name)).name)
        return
    found = sorted(path.glob("*.mcap"), key=_number)
    if not found:
        other = (
            "rosbag2's sqlite3 files; convert them: ros2 bag convert" if list(path.glob("*.db3")) else "no .mcap file"
        )
        raise BagError(f"{path} is no bag: it has no {FILE_NAME}, and holds {other}")
    problems.append(f"{path} has no {FILE_NAME}: its recorder was killed (`repair` makes a complete copy for ros2 bag)")
    filled = [p for p in found if p.stat().st_size]
    problems += [f"{p.name} is empty (0 bytes)" for p in found if p not in filled]
    for file in filled or found[:1]:
        yield McapFile(file)


def _number(path: Path) -> tuple[int, str]:
    match = re.search(r"_(\d+)$", path.stem)
    return (int(match[1]) if match else -1, path.name)
