"""Wait for a thread that works off a queue, as long as it gets on with it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from mbd_bag.errors import BagError

STALLED = 60.0  # [s] without anything done after which a disk is taken for dead


def wait_for_end(thread: threading.Thread, backlog: Callable[[], int], stalled: float = STALLED) -> None:
    """Wait for a thread's end.

    Args:
        thread: a daemon, so that the process can end without it.
        backlog: how many jobs it has not begun.
        stalled: how long it may go without beginning another job [s].

    Raises:
        BagError: it did not get on with its work.
    """
    left, since = backlog(), time.monotonic()
    while thread.is_alive():
        thread.join(min(1.0, stalled))
        if (now := backlog()) != left:
            left, since = now, time.monotonic()
        elif thread.is_alive() and time.monotonic() - since > stalled:
            raise BagError(
                f"the {thread.name} has done nothing for {stalled:g} s and {left} of its jobs are left: is the disk "
                f"still there? The bag holds what was written before; read it as it is"
            )
