"""How much a recorder keeps in memory until it is written, and which pictures it leaves out rather than keep more."""

from __future__ import annotations

import threading


class MemoryBudget:
    """Bytes that wait to be compressed or written, counted from any thread.

    Small messages always find room: they are the session's own, and few bytes. Pictures are kept all while half of the
    budget is free, then every second one, every fourth, and none when it is used up; so what comes is kept evenly
    rather than in blocks.

    Args:
        limit: for pictures [byte].
    """

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self._used = 0
        self._lock = threading.Lock()

    @property
    def used(self) -> int:
        """Bytes waiting."""
        return self._used

    def take(self, size: int) -> None:
        """Count bytes that begin to wait."""
        with self._lock:
            self._used += size

    def give(self, size: int) -> None:
        """Count bytes that wait no longer."""
        with self._lock:
            self._used -= size

    def keeps(self, number: int) -> bool:
        """Whether there is room for a picture.

        Args:
            number: of the picture in its topic.
        """
        share = self._used / self._limit
        if share >= 1.0:
            return False
        return number % (1 if share < 0.5 else 2 if share < 0.75 else 4) == 0
