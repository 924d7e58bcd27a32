"""A ROS domain of one's own, so that two sessions or tests on one machine never hear each other."""

from __future__ import annotations

import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mbd_model.errors import MbdError

# Fast DDS derives ports from the domain; above 101 they reach into Linux's ephemeral range.
FIRST, LAST = 50, 101


@contextmanager
def private_domain() -> Iterator[int]:
    """A domain that nobody else who asks here is using; held by a file lock until the block ends, whatever ends it.

    Raises:
        MbdError: every domain is taken.
    """
    folder = Path(tempfile.gettempdir()) / f"mbd_ros_domains_{os.getuid()}"
    folder.mkdir(exist_ok=True)
    for domain in range(FIRST, LAST + 1):
        with (folder / str(domain)).open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            yield domain
            return
    raise MbdError(f"no free ROS domain between {FIRST} and {LAST}: end a session or test that is still running")
