"""A bag while it is written: its writer, the threads before it, and which topics it knows already."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from mbd_bag.images.image_cdr import IMAGE
from mbd_bag.recorder.encoding_thread import EncodingThread
from mbd_bag.recorder.log_clock import LogClock
from mbd_bag.recorder.memory_budget import MemoryBudget
from mbd_bag.recorder.parameters import RecorderConfig
from mbd_bag.recorder.topic_counts import TopicCount, count_facts
from mbd_bag.recorder.writing_thread import WritingThread
from mbd_bag.storage.bag_metadata import TopicRecord


class BagOutput:
    """Takes serialized messages in order, from its making to `close`; no call waits for compression or the disk.

    Args:
        config: of the recorder.
        budget: of its memory.
        warn: takes one sentence when something is amiss.
        again: go on in the bag although it was closed.
        flushed: see `WritingThread`.

    Attributes:
        writer: of the bag; nobody else may use it.
        clock: gives the log times.

    Raises:
        BagError: the bag's place cannot be used.
    """

    def __init__(
        self,
        config: RecorderConfig,
        budget: MemoryBudget,
        warn: Callable[[str], object],
        *,
        again: bool = False,
        flushed: Callable[[str], object] = lambda _: None,
    ) -> None:
        self._config, self._budget, self._warn = config, budget, warn
        self.writer = config.open_bag(again=again)
        self.clock = LogClock(self.writer.last_log_time)
        self._thread = WritingThread(
            self.writer,
            min_free=int(config.min_free * 1e6),
            stop_free=int(config.stop_free * 1e6),
            warn=warn,
            budget=budget,
            flushed=flushed,
            file_size=int(config.file_size * 1e6),
        )
        self._known: set[str] = set()
        self._encoders: dict[str, EncodingThread] = {}

    @property
    def failure(self) -> Exception | None:
        """Why writing stopped, None while all is well."""
        return self._thread.failure

    def knows(self, topic: str) -> bool:
        """Whether that topic was added."""
        return topic in self._known

    def add_topic(self, record: TopicRecord, definition: str) -> None:
        """Make a topic known to the bag; images are compressed where the config says so."""
        self._known.add(record.name)
        if self._config.images == "compressed" and record.msgtype == IMAGE:
            quality = self._config.jpeg_quality
            self._encoders[record.name] = EncodingThread(record, self._thread, quality, self._warn, self._budget)
        else:
            self._thread.add_topic(record, definition)

    def write(self, topic: str, log_time: int, data: bytes, published: int, written: Callable[[], object]) -> None:
        """Take a message of a known topic; times [ns] and ``written`` as `WritingThread.write` has them."""
        encoder = self._encoders.get(topic)
        if encoder is None:
            self._thread.write(topic, log_time, data, published, written)
        else:
            encoder.write(log_time, data, published, written)

    def add_facts(self, facts: Mapping[str, str]) -> None:
        """Add facts of the session."""
        self._thread.add_facts(facts)

    def close(self, counts: Mapping[str, TopicCount]) -> None:
        """Compress and write what has arrived, add the counts, and finish the bag; raises what writing it raised."""
        for encoder in self._encoders.values():
            encoder.close()
        self._thread.add_final_facts(lambda: count_facts(counts))
        self._thread.close()
