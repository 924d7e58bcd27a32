"""A ROS domain of one's own, so that two sessions or tests on one machine never receive each other's messages."""

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

    It is the one that has been free longest: a process that is slow to end meets nobody in its old domain.

    Raises:
        MbdError: every domain is taken.
    """
    folder = Path(tempfile.gettempdir()) / f"mbd_ros_domains_{os.getuid()}"
    folder.mkdir(exist_ok=True)
    for domain in sorted(range(FIRST, LAST + 1), key=lambda number: _used_last(folder / str(number))):
        with (folder / str(domain)).open("a") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            os.utime(lock.fileno())
            try:
                yield domain
            finally:
                os.utime(lock.fileno())
            return
    raise MbdError(f"no free ROS domain between {FIRST} and {LAST}: end a session or test that is still running")


def _used_last(file: Path) -> int:
    """When the domain of this lock was last taken or given back [ns], 0 for never."""
    try:
        return file.stat().st_mtime_ns
    except FileNotFoundError:
        return 0
