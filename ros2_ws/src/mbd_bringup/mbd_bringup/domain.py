"""A ROS domain of one's own, so that two sessions or tests on one machine never receive each other's messages."""

from __future__ import annotations

import fcntl
import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from mbd_model.errors import MbdError

# Fast DDS derives ports from the domain; above 101 they reach into Linux's ephemeral range.
FIRST, LAST = 50, 101


@contextmanager
def private_domain() -> Iterator[int]:
    """A domain that nobody else who asks here is using; held by a file lock until the block ends, whatever ends it.

    It is the one that has been free longest: a process that is slow to end meets nobody in its old domain.

    Raises:
        MbdError: every domain is taken, or the folder of the locks is not this user's alone.
    """
    folder = _lock_folder()
    for domain in sorted(range(FIRST, LAST + 1), key=lambda number: _used_last(folder / str(number))):
        with open(_open_lock(folder / str(domain)), "a") as lock:
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


def _lock_folder() -> Path:
    """The folder of the locks, which nobody else may put files or links into.

    Its name can be foreseen, and everybody may make it: another's, or a link to somewhere, is not used.
    """
    folder = Path(tempfile.gettempdir()) / f"mbd_ros_domains_{os.getuid()}"
    try:
        with suppress(FileExistsError):
            folder.mkdir(mode=0o700)
        found = folder.lstat()
    except OSError as error:
        raise MbdError(
            f"{folder} cannot be made ({error.strerror}): free it, or set TMPDIR to a folder of yours"
        ) from error
    if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid():
        raise MbdError(f"{folder} is not a folder of this user: somebody else made it; remove it, or set TMPDIR")
    if found.st_mode & 0o022:
        folder.chmod(0o700)
    return folder


def _open_lock(file: Path) -> int:
    """A descriptor of the lock's file, made where it is missing; a link in its place is never followed."""
    try:
        return os.open(file, os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_NOFOLLOW, 0o600)
    except OSError as error:
        raise MbdError(f"{file} cannot be the lock of a ROS domain ({error.strerror}); remove it") from error


def _used_last(file: Path) -> int:
    """When the domain of this lock was last taken or given back [ns], 0 for never."""
    try:
        return file.lstat().st_mtime_ns
    except FileNotFoundError:
        return 0
