"""The file under an MCAP writer: only complete records reach it, however its process or its disk ends."""

from __future__ import annotations

import errno
import fcntl
import os
import threading
from collections import deque
from pathlib import Path

from mbd_bag.errors import BagError

HELD = 64_000_000  # [byte] kept in memory while the disk takes nothing
FULL = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})  # what may pass, when somebody makes room


class RecordFile:
    """A new file. Each call of the writer carries complete records, and each is handed to the system at once.

    Without a buffer of its own a killed process leaves no half record: all that was written can be read. A disk that
    is full takes none of a record rather than a part; what it did not take is held and written later, in order.

    Args:
        path: of the file; it must not exist.

    Attributes:
        path: where it is.
        held: bytes that the disk did not take yet.
        synced: how much of it survives a power cut [byte].

    Raises:
        OSError: it exists, or cannot be written.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file = path.open("xb", buffering=0)
        self._folder = path.parent
        self._syncing = threading.Lock()
        self._records: deque[bytes] = deque()
        self._end = 0
        self.held = self.synced = 0

    @property
    def closed(self) -> bool:
        """True after `close`."""
        return self._file.closed

    def fileno(self) -> int:
        """The system's number of the open file."""
        return self._file.fileno()

    def tell(self) -> int:
        """How much was written, and is to be [byte]."""
        return self._end + self.held

    def write(self, data: bytes | bytearray | memoryview) -> int:
        """Write all of it, or hold it; raises OSError where the disk fails otherwise, or ``HELD`` is not enough."""
        self._records.append(bytes(data))
        self.held += len(data)
        self._write_held(HELD)
        return len(data)

    def flush(self) -> None:
        """Try once more to write what is held."""
        self._write_held(HELD)

    def _write_held(self, allowed: int) -> None:
        try:
            while self._records:
                rest = memoryview(self._records[0])
                while rest:
                    rest = rest[self._file.write(rest) :]
                record = self._records.popleft()
                self._end += len(record)
                self.held -= len(record)
        except OSError as error:
            self._file.seek(self._end)
            self._file.truncate()
            if error.errno not in FULL or self.held > allowed:
                raise

    def sync(self) -> None:
        """Have the disk keep what was written so far, also when the power fails; raises OSError. From any thread."""
        with self._syncing:
            end = self._end
            if end == self.synced or self._file.closed:
                return
            if not self.synced:
                _sync_folder(self._folder)
            os.fdatasync(self._file.fileno())
            self.synced = end

    def close(self) -> None:
        """Write what is held and close the file; one that was synced before is, to its end. Raises OSError."""
        try:
            self._write_held(0)
            if self.synced:
                self.sync()
        finally:
            with self._syncing:
                self._file.close()


def _sync_folder(folder: Path) -> None:
    """Have the disk keep that a file was added: without that its contents are nowhere after a power cut."""
    number = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)


def refuse_if_written(path: Path) -> None:
    """Raises BagError when a recorder at work holds its lock on this file."""
    with path.open("rb") as stream:
        try:
            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise BagError(f"another recorder is writing {path.parent}; stop it, or record into another bag") from error
