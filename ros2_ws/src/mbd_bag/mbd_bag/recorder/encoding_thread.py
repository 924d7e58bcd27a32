"""A thread that compresses the images of one topic, in order, on their way to the bag."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from dataclasses import dataclass

from mbd_bag.errors import BagError
from mbd_bag.images.image_cdr import COMPRESSED_IMAGE
from mbd_bag.images.image_compression import compress
from mbd_bag.recorder.memory_budget import MemoryBudget
from mbd_bag.recorder.thread_end import wait_for_end
from mbd_bag.recorder.writing_thread import WritingThread
from mbd_bag.storage.bag_metadata import TopicRecord
from mbd_bag.storage.definitions import full_definition, type_hash


@dataclass(frozen=True)
class _Job:
    log_time: int
    publish_time: int
    data: bytes
    written: Callable[[], object]


class EncodingThread:
    """Takes serialized Images of one topic and writes them compressed; OpenCV works outside Python's lock.

    An image that cannot be compressed (other encodings than colour of 8 bits or depth of 16) is written raw.

    Args:
        topic: the raw topic.
        thread: that writes the bag.
        quality: of JPEG, 1..100.
        warn: takes one sentence when an image cannot be read.
        budget: counts what waits.
    """

    def __init__(
        self,
        topic: TopicRecord,
        thread: WritingThread,
        quality: int,
        warn: Callable[[str], object] = lambda _: None,
        budget: MemoryBudget | None = None,
    ) -> None:
        self._budget = budget or MemoryBudget(1 << 40)
        self._topic = topic
        self._writing = thread
        self._quality = quality
        self._warn = warn
        self._known: set[str] = set()
        self._jobs: queue.SimpleQueue[_Job | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name=f"encoder of {topic.name}", daemon=True)
        self._thread.start()

    @property
    def backlog(self) -> int:
        """Images not yet compressed."""
        return self._jobs.qsize()

    def write(
        self, log_time: int, data: bytes, publish_time: int, written: Callable[[], object] = lambda: None
    ) -> None:
        """Take one message; times [ns] and ``written`` as `WritingThread.write` has them. Returns at once."""
        self._budget.take(len(data))
        self._jobs.put(_Job(log_time, publish_time, data, written))

    def close(self) -> None:
        """Compress what is waiting and end the thread."""
        self._jobs.put(None)
        wait_for_end(self._thread, self._jobs.qsize)

    def _run(self) -> None:
        while (job := self._jobs.get()) is not None:
            try:
                compressed = compress(job.data, self._quality)
            except BagError as error:
                self._warn(f"an image of {self._topic.name} is recorded as it came: {error}")
                compressed = None
            topic = self._record("" if compressed is None else compressed.suffix)
            data = job.data if compressed is None else compressed.data
            self._budget.give(len(job.data))
            self._writing.write(topic, job.log_time, data, job.publish_time, job.written)

    def _record(self, suffix: str) -> str:
        """Name of the topic with this suffix, made known to the bag: only an image shows which one it goes to."""
        name = self._topic.name + suffix
        if name not in self._known:
            self._known.add(name)
            kind = COMPRESSED_IMAGE if suffix else self._topic.msgtype
            self._writing.add_topic(TopicRecord(name, kind, type_hash(kind), self._topic.qos), full_definition(kind))
        return name
