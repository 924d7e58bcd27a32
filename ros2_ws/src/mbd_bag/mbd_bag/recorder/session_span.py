"""When a recording ends with its session, and what makes it go on."""

from __future__ import annotations

import re

from mbd_model.session import Phase

STATE = "interaction/state"
OVER = (Phase.DONE, Phase.ABORTED)
# What people do, and what answers them: it belongs to the session however late it comes.
_OF_PEOPLE = re.compile(r"(.*/)?(wizard|study|stop|interaction)(/.*)?")
_LINGER = 2.0  # [s] from the session's last word to the closing of its bag


class SessionSpan:
    """Follows a session's phases and its people's words, by a steady clock.

    Args:
        follows: whether the recording ends with the session at all.
    """

    def __init__(self, *, follows: bool) -> None:
        self._follows = follows
        self._over = False
        self._last_word = 0.0

    @property
    def over(self) -> bool:
        """The session has ended, and whoever records need not keep what flows on: pictures, joints, the clock."""
        return self._over

    def enter(self, phase: Phase, at: float) -> None:
        """The session states its phase; ``at`` [s]."""
        over = self._follows and phase in OVER
        if over != self._over:
            self._over, self._last_word = over, at

    def keeps(self, topic: str, at: float) -> bool:
        """Whether a message of that topic that arrives at ``at`` [s] is part of the session."""
        if not self._over:
            return True
        if _OF_PEOPLE.fullmatch(topic):
            self._last_word = at
            return True
        # What the nodes still had to say when it ended.
        return at - self._last_word < _LINGER

    def closes(self, at: float) -> bool:
        """Whether the bag is to be closed at ``at`` [s]."""
        return self._over and at - self._last_word >= _LINGER
