"""What a recorder has missed of the session's own topics, taken from the spools' journals."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Mapping
from pathlib import Path

from mbd_bag.errors import BagError
from mbd_bag.recorder.parameters import RecorderConfig
from mbd_bag.spool.parameters import WRITERS
from mbd_bag.spool.reconciliation import Reconciliation
from mbd_bag.spool.spool_file import Key, SpooledMessage, SpoolReader, spool_path
from mbd_bag.spool.written_keys import KeyLog, keys_path, known_keys, logged_keys


class MissedMessages:
    """Logs what the bag holds, and finds in the journal what it does not.

    Messages arrive in the node's thread; `written` and `flushed` are called in the thread that writes the bag.

    Args:
        config: of the recorder.
        counts: messages by topic, of each file of the bag that was there before.
        warn: takes one sentence when something is amiss.

    Raises:
        BagError: the folder cannot be written.
    """

    def __init__(
        self, config: RecorderConfig, counts: Mapping[str, Mapping[str, int]], warn: Callable[[str], object]
    ) -> None:
        folder = Path(config.spool).expanduser().absolute()
        log = keys_path(folder, config.run)
        self._readers = [SpoolReader(spool_path(folder, config.run, writer)) for writer in WRITERS]
        spooled = self._newly_spooled()
        self._reconciliation = Reconciliation(known_keys(logged_keys(log), counts, spooled))
        now = time.monotonic()
        for message in spooled:
            self._reconciliation.spooled(message, now)
        self._spooled_before = [(message.received, message.session_time) for message in spooled]
        self._warn = warn
        self._fresh: list[Key] = []
        self._passed: list[Key] = []
        try:
            self._log = KeyLog(log)
        except OSError as error:
            raise BagError(
                f"spool {folder} cannot be written ({error.strerror}): give a folder that this user may write"
            ) from error

    def spooled_until(self, *, sim_time: bool) -> int:
        """When the last message came that was spooled before this recorder began, by the session's clock [ns]."""
        return max((session if sim_time else received for received, session in self._spooled_before), default=0)

    def receive(self, key: Key) -> bool:
        """A message arrived by itself; False when it was taken from the journal before."""
        return self._reconciliation.receive(key)

    def pass_over(self, key: Key) -> None:
        """A message is no part of the recording."""
        self._passed.append(key)

    def written(self, key: Key) -> None:
        """A message is in the bag's file, which is not flushed yet."""
        self._fresh.append(key)

    def flushed(self, file: str) -> None:
        """The bag's file was flushed."""
        fresh, self._fresh = self._fresh, []
        # Where it cannot: whoever goes on counts the bag's messages, and takes those that no line names for the
        # oldest ones spooled.
        with contextlib.suppress(OSError):
            self._log.add(file, fresh)

    def log_passed(self) -> None:
        """Log what was passed over."""
        passed, self._passed = self._passed, []
        with contextlib.suppress(OSError):
            self._log.pass_over(passed)

    def missing(self, *, everything: bool = False) -> list[SpooledMessage]:
        """What the bag lacks by now, oldest first; each once.

        Args:
            everything: also what may still arrive by itself.
        """
        now = float("inf") if everything else time.monotonic()
        for message in self._newly_spooled():
            self._reconciliation.spooled(message, time.monotonic())
        return self._reconciliation.missing(now)

    def _newly_spooled(self) -> list[SpooledMessage]:
        """What was added to the journals, oldest first; what both have is there twice."""
        return sorted((m for reader in self._readers for m in reader.new()), key=lambda message: message.received)

    def close(self) -> None:
        """The recorder ends."""
        self._log.close()
