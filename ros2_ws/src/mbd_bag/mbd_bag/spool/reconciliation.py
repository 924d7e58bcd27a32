"""Compares what a recorder received with what was spooled, and finds what the recorder missed."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable

from mbd_bag.spool.spool_file import Key, SpooledMessage

GRACE = 3.0  # [s] for a message that was spooled to arrive at the recorder itself
_KNOWN = 200_000  # keys kept in memory


class Reconciliation:
    """Remembers keys; a message that was spooled, and did not arrive in time, is missing.

    Args:
        known: keys of the messages that the bag holds already, or is not to hold.
        grace: for a message to arrive [s].
    """

    def __init__(self, known: Iterable[Key] = (), grace: float = GRACE) -> None:
        self._known: OrderedDict[Key, None] = OrderedDict.fromkeys(known)
        self._taken_in: set[Key] = set()
        self._grace = grace
        self._waiting: OrderedDict[Key, tuple[float, SpooledMessage]] = OrderedDict()

    def receive(self, key: Key) -> bool:
        """A message arrived; False when it was taken from the journal before, and is not to be written twice."""
        if key in self._taken_in:
            return False
        self._remember(key)
        return True

    def _remember(self, key: Key) -> None:
        self._known[key] = None
        self._waiting.pop(key, None)
        while len(self._known) > _KNOWN:
            self._known.popitem(last=False)

    def spooled(self, message: SpooledMessage, now: float) -> None:
        """A message is in the journal; ``now`` [s] by a steady clock."""
        if message.key not in self._known and message.key not in self._waiting:
            self._waiting[message.key] = now + self._grace, message

    def missing(self, now: float) -> list[SpooledMessage]:
        """What is to be written from the journal at ``now`` [s], oldest first; each is returned once."""
        due = [message for at, message in self._waiting.values() if at <= now]
        for message in due:
            self._taken_in.add(message.key)
            self._remember(message.key)
        return due
