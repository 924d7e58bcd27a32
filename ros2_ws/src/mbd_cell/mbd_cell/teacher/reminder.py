"""When the teacher says a word again that nobody acted on: after longer waits each time, so that nobody is nagged."""

from __future__ import annotations

LONGEST = 60.0  # [s]


class Reminder:
    """Each word is repeated after ``first``, then twice that, and so on up to 5 times that, or LONGEST; steady clock.

    Args:
        first: wait before the first repetition [s].
    """

    def __init__(self, first: float) -> None:
        self._first = first
        self._said_at = 0.0
        self._repeated = 0

    def said(self, at: float) -> None:
        """A word was said for the first time, at ``at`` [s]."""
        self._said_at, self._repeated = at, 0

    def due(self, at: float) -> bool:
        """Whether it is to be said again at ``at`` [s]; counts as said when it is."""
        longest = max(self._first, min(5.0 * self._first, LONGEST))
        if at - self._said_at < min(self._first * 2**self._repeated, longest):
            return False
        self._said_at, self._repeated = at, self._repeated + 1
        return True

    @property
    def repeated(self) -> int:
        """How often it was said again."""
        return self._repeated
