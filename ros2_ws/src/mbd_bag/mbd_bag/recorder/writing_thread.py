"""A thread that writes a bag, so that whoever receives messages never waits for compression or the disk."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Mapping

from mbd_bag.errors import BagError
from mbd_bag.recorder.memory_budget import MemoryBudget
from mbd_bag.recorder.thread_end import wait_for_end
from mbd_bag.storage.bag_metadata import TopicRecord
from mbd_bag.storage.bag_writer import BagWriter
from mbd_bag.storage.record_file import HELD

_SYNC_PERIOD = 1.0  # [s] between two syncs: a power cut costs that, what is not flushed yet, and the sync itself
_SPACE_PERIOD = 5.0  # [s] between looks at the free space


class WritingThread:
    """Owns a BagWriter from its start to `close`; every call returns at once and is performed in order.

    Args:
        writer: the bag; nobody else may use it meanwhile.
        flush_period: at most this long a message is kept in memory only [s].
        min_free: free space below which to warn [byte].
        stop_free: free space below which the bag is closed while it still can be [byte].
        space_period: between looks at the free space [s].
        warn: takes one sentence when the disk runs short.
        budget: counts what waits.
        file_size: of a file after which the bag's next begins [byte].
        flushed: is called with the file's name whenever it was flushed, in the thread.

    Attributes:
        failure: why writing stopped, None while all is well.
    """

    def __init__(
        self,
        writer: BagWriter,
        *,
        flush_period: float = 0.5,
        min_free: int = 0,
        stop_free: int = 0,
        space_period: float = _SPACE_PERIOD,
        warn: Callable[[str], object] = lambda _: None,
        budget: MemoryBudget | None = None,
        flushed: Callable[[str], object] = lambda _: None,
        file_size: int = 1 << 60,
    ) -> None:
        self._writer = writer
        self._budget = budget or MemoryBudget(1 << 40)
        self._flush_period = flush_period
        self._min_free = min_free
        self._stop_free = stop_free
        self._space_period = space_period
        self._warn = warn
        self._flushed = flushed
        self._file_size = file_size
        self._jobs: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self.failure: Exception | None = None
        self._thread = threading.Thread(target=self._run, name="bag writer", daemon=True)
        # A thread of its own: a disk may take seconds to sync, in which others write on.
        self._over = threading.Event()
        self._syncing = threading.Thread(target=self._sync_often, name="bag syncer", daemon=True)
        self._thread.start()
        self._syncing.start()

    @property
    def backlog(self) -> int:
        """Calls not yet performed."""
        return self._jobs.qsize()

    def add_topic(self, topic: TopicRecord, definition: str) -> None:
        """See `BagWriter.add_topic`."""
        self._jobs.put(lambda: self._writer.add_topic(topic, definition))

    def write(
        self,
        topic: str,
        log_time: int,
        data: bytes,
        publish_time: int | None = None,
        written: Callable[[], object] = lambda: None,
    ) -> None:
        """See `BagWriter.write`; ``written`` is called once that is done, in the thread."""
        self._budget.take(len(data))

        def job() -> None:
            self._budget.give(len(data))
            self._writer.write(topic, log_time, data, publish_time)
            written()

        self._jobs.put(job)

    def add_facts(self, facts: Mapping[str, str]) -> None:
        """See `BagWriter.add_facts`."""
        self._jobs.put(lambda: self._writer.add_facts(facts))

    def add_final_facts(self, facts: Callable[[], Mapping[str, str]]) -> None:
        """Add facts that are known once all before is written."""
        self._jobs.put(lambda: self._writer.add_facts(facts()))

    def close(self) -> None:
        """Write what is waiting, finish the bag and end the thread; raises the failure when there was one."""
        self._jobs.put(None)
        wait_for_end(self._thread, self._jobs.qsize)
        if self.failure is not None:
            raise self.failure

    def _run(self) -> None:
        try:
            self._write_all()
        except (OSError, BagError) as error:
            self.failure = error
        self._over.set()  # whoever still syncs is waited for by the file, when it is closed
        try:
            self._writer.close()
            self._flushed(self._writer.path.name)
        except (OSError, ValueError) as error:
            self.failure = self.failure or error

    def _sync_often(self) -> None:
        while not self._over.wait(_SYNC_PERIOD):
            try:
                self._writer.sync()
            except OSError as error:
                self._warn(f"the disk does not keep what is written ({error.strerror}): a power cut may cost it")
                return

    def _flush(self) -> None:
        held_before = self._writer.held
        self._writer.flush()
        held = self._writer.held
        if held and not held_before:
            self._warn(
                "the disk takes nothing: what comes is held in memory, up to "
                f"{HELD / 1e6:.0f} MB, and written when there is room; make room where the bag is"
            )
        if held:
            return  # nothing of it would survive this process
        self._flushed(self._writer.path.name)
        if self._writer.size >= self._file_size:
            self._writer.begin_next()

    def _write_all(self) -> None:
        flushed = looked = time.monotonic()
        while True:
            try:
                job = self._jobs.get(timeout=self._flush_period / 2)
                if job is None:
                    return
                job()
            except queue.Empty:
                pass
            now = time.monotonic()
            if now - flushed >= self._flush_period / 2:
                self._flush()
                flushed = now
            if now - looked >= self._space_period:
                looked = now
                free = self._writer.free_space()
                if free < self._stop_free:
                    raise BagError(
                        f"only {free / 1e6:.0f} MB are free, so the bag was closed while that is possible. Make room, "
                        f"and go on in it with resume:=true"
                    )
                if free < self._min_free:
                    self._warn(f"only {free / 1e6:.0f} MB are free where the bag is written; make room")
