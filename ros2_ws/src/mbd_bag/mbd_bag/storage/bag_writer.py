"""Write a session bag: rosbag2's folder with MCAP files and, once it is closed, metadata.yaml.

A bag is a folder ``<bag>/`` with ``<bag>_0.mcap``, ``<bag>_1.mcap``, ... Nothing in it is ever overwritten. A recorder
that died left no metadata.yaml; the next one completes its last file and goes on in the next.
"""

from __future__ import annotations

import fcntl
import re
import shutil
from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from types import TracebackType
from typing import IO, Self, cast

from mcap.data_stream import RecordBuilder
from mcap.records import Channel, Schema
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter

from mbd_bag.errors import BagError
from mbd_bag.storage.bag_metadata import FILE_NAME, FileRecord, TopicRecord, write_metadata
from mbd_bag.storage.finishing import FACTS_RECORD, records_of
from mbd_bag.storage.mcap_completion import complete
from mbd_bag.storage.mcap_file import LIBRARY, McapFile
from mbd_bag.storage.record_file import RecordFile, refuse_if_written
from mbd_bag.storage.topic_qos import as_yaml


class Compression(StrEnum):
    """Of each chunk. LZ4 keeps up with RGB-D at 30 Hz; ZSTD is smaller, and does not."""

    NONE = "none"
    LZ4 = "lz4"
    ZSTD = "zstd"


def bag_files(folder: Path) -> list[Path]:
    """The folder's ``<bag>_N.mcap`` files in the order recorded."""
    pattern = re.compile(rf"{re.escape(folder.name)}_(\d+)\.mcap")
    numbered = ((pattern.fullmatch(p.name), p) for p in folder.iterdir())
    return [p for _, p in sorted((int(match[1]), p) for match, p in numbered if match)]


class BagWriter:
    """Writes one bag (or the next file of one).

    Args:
        folder: the bag; made when missing.
        distro: name of the ROS distribution, for metadata.yaml.
        compression: of the chunks.
        resume: go on in a bag that was finished. One whose recorder died is gone on with in any case.
        min_free: free space to insist on at the start [byte].

    Attributes:
        last_log_time: latest log time in the bag, earlier files included [ns].

    Raises:
        BagError: the bag exists and is finished, is being written, holds other things, or the disk is full.
    """

    def __init__(
        self,
        folder: Path,
        *,
        distro: str = "jazzy",
        compression: Compression = Compression.LZ4,
        resume: bool = False,
        min_free: int = 0,
    ) -> None:
        self.folder = folder
        self._distro = distro
        self._facts: dict[str, str] = {}
        self._topics: dict[str, TopicRecord] = {}
        self._done: list[FileRecord] = []
        self._schemas: dict[str, int] = {}
        self._declared_since: list[Schema | Channel] = []
        self._channels: dict[str, int] = {}
        self._definitions: dict[str, str] = {}
        self._counts: dict[str, int] = {}
        self._start = self._end = self._written = 0
        self.last_log_time = 0
        number = self._take_over(resume) if folder.exists() else 0
        folder.mkdir(parents=True, exist_ok=True)
        self._check_space(min_free)
        self._compression = CompressionType[compression.name]
        self._open(number)

    def _open(self, number: int) -> None:
        self._number = number
        self.path = self.folder / f"{self.folder.name}_{number}.mcap"
        self._stream = RecordFile(self.path)
        # Held until this process ends, however it ends: distinguishes a recorder at work from one that died.
        fcntl.flock(self._stream.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
        self._mcap = McapWriter(cast(IO[bytes], self._stream), compression=self._compression)
        self._mcap.start(profile="ros2", library=LIBRARY)
        if self._facts:
            self._mcap.add_metadata(FACTS_RECORD, self._facts)

    def _take_over(self, resume: bool) -> int:
        """Complete the files of an existing bag and read what they hold; returns the number of the next one."""
        if not self.folder.is_dir():
            raise BagError(f"{self.folder} is a file; give the bag (a folder) another name")
        files = bag_files(self.folder)
        finished = (self.folder / FILE_NAME).exists()
        if finished and not resume:
            raise BagError(
                f"the bag {self.folder} exists already and is never overwritten; choose another name, "
                f"go on in it with resume:=true, or record the episode again with redo:=true (the old bag is kept)"
            )
        if not files and any(self.folder.iterdir()):
            raise BagError(f"{self.folder} holds other files than a bag's; choose another name")
        if not files:
            return 0
        refuse_if_written(files[-1])
        for path in files:
            # A recorder that died before its first byte leaves an empty file: nothing to take over.
            if path.stat().st_size:
                self._remember(complete(path))
        # Until it is closed again the bag is unfinished, and metadata.yaml would lack the file to come.
        (self.folder / FILE_NAME).unlink(missing_ok=True)
        return int(files[-1].stem.rpartition("_")[2]) + 1

    def _remember(self, file: McapFile) -> None:
        topics, facts, record = records_of(file)
        for topic in topics:
            self._topics.setdefault(topic.name, topic)
        self._facts |= facts
        self._done.append(record)
        self.last_log_time = max(self.last_log_time, record.end)

    def _check_space(self, min_free: int) -> None:
        free = shutil.disk_usage(self.folder).free
        if free < min_free:
            raise BagError(
                f"only {free / 1e6:.0f} MB are free where {self.folder} is to be written; expected at least "
                f"{min_free / 1e6:.0f} MB. Make room, or record elsewhere"
            )

    @property
    def earlier(self) -> tuple[FileRecord, ...]:
        """The files of the bag that were there before, or are finished."""
        return tuple(self._done)

    @property
    def counts(self) -> dict[str, int]:
        """Messages by topic so far, earlier files included."""
        total = dict(self._counts)
        for file in self._done:
            for topic, count in file.counts.items():
                total[topic] = total.get(topic, 0) + count
        return total

    def free_space(self) -> int:
        """Free space where the bag is [byte]."""
        return shutil.disk_usage(self.folder).free

    def add_topic(self, topic: TopicRecord, definition: str) -> None:
        """Make a topic known before its first message.

        Args:
            topic: its name, type, hash and offered profiles.
            definition: the full text of its type, see `definitions.full_definition`.

        Raises:
            BagError: the topic is in the bag with another type.
        """
        known = self._topics.get(topic.name)
        if known is not None and known.msgtype != topic.msgtype:
            raise BagError(f"topic {topic.name} is '{topic.msgtype}' now and '{known.msgtype}' in the bag; rename one")
        if topic.name in self._channels:
            return
        if topic.msgtype not in self._schemas:
            encoding = "ros2msg" if definition else ""
            number = self._mcap.register_schema(topic.msgtype, encoding, definition.encode())
            self._schemas[topic.msgtype] = number
            self._declared_since.append(Schema(number, definition.encode(), encoding, topic.msgtype))
        schema = self._schemas[topic.msgtype]
        offered = {"offered_qos_profiles": as_yaml(topic.qos), "topic_type_hash": topic.type_hash}
        channel = self._mcap.register_channel(topic.name, "cdr", schema, offered)
        self._channels[topic.name] = channel
        self._definitions[topic.name] = definition
        self._declared_since.append(Channel(channel, topic.name, "cdr", offered, schema))
        self._topics[topic.name] = topic
        self._counts[topic.name] = 0

    def write(self, topic: str, log_time: int, data: bytes, publish_time: int | None = None) -> None:
        """Add one message.

        Args:
            topic: a topic made known by `add_topic`; raises BagError for another.
            log_time: when it was received [ns].
            data: its CDR bytes.
            publish_time: when it was published [ns]; the log time when not known.
        """
        if topic not in self._channels:
            raise BagError(f"topic {topic} is not known to the bag; call add_topic first")
        self._mcap.add_message(
            self._channels[topic],
            log_time,
            data,
            log_time if publish_time is None else publish_time,
            self._counts[topic],
        )
        self._start = min(self._start, log_time) if self._written else log_time
        self._written += 1
        self._end = max(self._end, log_time)
        self._counts[topic] += 1
        self.last_log_time = max(self.last_log_time, log_time)

    def add_facts(self, facts: Mapping[str, str]) -> None:
        """Add what is true of the complete session (participant, parameters, versions); later values win."""
        self._facts |= facts
        self._mcap.add_metadata(FACTS_RECORD, dict(facts))

    def flush(self) -> None:
        """Hand everything to the operating system: it survives this process being killed.

        What was declared since is written once more, outside of chunks: a damaged chunk, and with it the declarations
        that all later chunks need, then costs its own messages only.
        """
        self._mcap.flush()
        if self._declared_since:
            builder = RecordBuilder()
            for record in self._declared_since:
                record.write(builder)
            self._declared_since.clear()
            self._stream.write(builder.end())
        self._stream.flush()

    @property
    def held(self) -> int:
        """Bytes that the disk did not take yet, being full."""
        return self._stream.held

    @property
    def size(self) -> int:
        """Of the present file [byte]."""
        return self._stream.tell()

    def begin_next(self) -> None:
        """Finish the present file and go on in the bag's next: the one that a kill leaves unfinished stays small."""
        self._mcap.finish()
        self._stream.close()
        self._done.append(FileRecord(self.path.name, self._start, self._end, dict(self._counts)))
        declared = [(self._topics[name], self._definitions[name]) for name in self._channels]
        for of_file in (self._schemas, self._declared_since, self._channels, self._counts):
            of_file.clear()
        self._start = self._end = self._written = 0
        self._open(self._number + 1)
        for topic, definition in declared:
            self.add_topic(topic, definition)

    def sync(self) -> None:
        """Have the disk keep what was flushed, also when the power fails; raises OSError. From any thread."""
        self._stream.sync()

    @property
    def synced(self) -> tuple[Path, int]:
        """The present file, and how much of it survives a power cut [byte]; of the files before it all does."""
        stream = self._stream
        return stream.path, stream.synced

    def close(self) -> None:
        """Finish the file and write metadata.yaml. A second call does nothing."""
        if self._stream.closed:
            return
        self._mcap.finish()
        self._stream.close()
        files = [*self._done, FileRecord(self.path.name, self._start, self._end, dict(self._counts))]
        topics = [self._topics[name] for name in sorted(self._topics)]
        write_metadata(self.folder, topics, files, self._facts, self._distro)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
