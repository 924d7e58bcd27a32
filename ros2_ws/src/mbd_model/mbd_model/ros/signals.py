"""SIGINT and SIGTERM from a process's first moment on, however it was started."""

from __future__ import annotations

import signal
from types import FrameType


class StopRequest:
    """Remembers that the process was asked to stop, by SIGINT or SIGTERM.

    A process that a script starts in the background (``node &``) inherits SIGINT as ignored until it sets a handler of
    its own, and one that is interrupted while it still starts must not forget it. So make this before anything else.
    A handler that ROS or a web server installs later calls this one too, or takes its place; both are fine.
    """

    def __init__(self) -> None:
        self._asked = False
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._on_signal)

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        self._asked = True

    def __bool__(self) -> bool:
        """True once the process was asked to stop."""
        return self._asked
