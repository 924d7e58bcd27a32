"""A journal of small messages: appended by one process, read by another while it grows, cut off wherever it was killed.

Two files of bounded size, ``<run>.spool`` and the one before it, ``<run>.spool.old``: a gap in the bag is of the last
minutes, so what is older is forgotten. Two nodes write one each, ``<run>.second_spool`` the other.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from zlib import crc32

_HEAD = struct.Struct("<4sIIqqqQHH")
_MAGIC = b"MBDs"
_LARGEST = 16 << 20  # [byte] of one entry: larger is no message of a session's own
LIMIT = 32 << 20  # [byte] of a file, after which the next begins
_HELD = 64 << 20  # [byte] kept in memory while the disk is full

# A message's name among all of a session's: topic, its publisher's time [ns] and number.
Key = tuple[str, int, int]


@dataclass(frozen=True)
class SpooledMessage:
    """One message.

    Attributes:
        topic: absolute name.
        msgtype: ``package/msg/Type``.
        source: when it was published, by its publisher's clock [ns].
        number: its publisher's number.
        received: when it arrived, by the wall clock [ns].
        session_time: then, by the session's clock [ns]; 0 where that has not begun, or is the wall clock.
        data: its CDR bytes.
    """

    topic: str
    msgtype: str
    source: int
    number: int
    received: int
    session_time: int
    data: bytes

    @property
    def key(self) -> Key:
        """What names it."""
        return self.topic, self.source, self.number

    def packed(self) -> bytes:
        """As it stands in the file."""
        topic, kind = self.topic.encode(), self.msgtype.encode()
        body = topic + kind + self.data
        head = (self.source, self.received, self.session_time, self.number, len(topic), len(kind))
        return _HEAD.pack(_MAGIC, len(body), crc32(body), *head) + body


def _entries(data: bytes) -> Iterator[tuple[SpooledMessage, int]]:
    """Each complete entry with the offset behind it; stops before one that is cut off or damaged."""
    at = 0
    while at + _HEAD.size <= len(data):
        magic, size, check, source, received, time, number, topic, kind = _HEAD.unpack_from(data, at)
        body = data[at + _HEAD.size : at + _HEAD.size + size]
        if magic != _MAGIC or size > _LARGEST or len(body) < size or crc32(body) != check:
            return
        at += _HEAD.size + size
        names = body[: topic + kind].decode(errors="replace")
        yield SpooledMessage(names[:topic], names[topic:], source, number, received, time, body[topic + kind :]), at


def spool_path(folder: Path, run: str, writer: str = "spool") -> Path:
    """The journal of one start of a session, and of one of the nodes that write one."""
    return folder / f"{run or 'session'}.{writer}"


class SpoolWriter:
    """Appends to a journal, which it goes on with when it is there.

    Args:
        path: of the journal; its folder is made when missing.
        limit: of one file [byte].

    Raises:
        OSError: it cannot be written.
    """

    def __init__(self, path: Path, limit: int = LIMIT) -> None:
        self._path, self._limit = path, limit
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.exists():
            _cut(path)
        self._file = path.open("ab", buffering=0)
        self._held: list[bytes] = []
        self._unsynced = False

    @property
    def held(self) -> int:
        """Bytes that the disk would not take yet."""
        return sum(map(len, self._held))

    def append(self, message: SpooledMessage) -> None:
        """Add a message; where the disk takes none it is held in memory and written later."""
        if self.held < _HELD:
            self._held.append(message.packed())
        self.flush()

    def flush(self) -> bool:
        """Write what is held; False while the disk does not take it."""
        try:
            while self._held:
                if self._file.tell() > self._limit:
                    self._begin_next()
                self._write(self._held[0])
                del self._held[0]
        except OSError:
            return False
        return True

    def _write(self, data: bytes) -> None:
        end = self._file.seek(0, os.SEEK_END)
        rest = memoryview(data)
        try:
            while rest:
                rest = rest[self._file.write(rest) :]
        except OSError:
            self._file.truncate(end)
            raise
        self._unsynced = True

    def _begin_next(self) -> None:
        self._file.close()
        self._path.replace(self._path.with_name(self._path.name + ".old"))
        self._file = self._path.open("ab", buffering=0)

    def sync(self) -> None:
        """Have the disk keep what was written, also when the power fails; raises OSError."""
        if self._unsynced:
            os.fdatasync(self._file.fileno())
            self._unsynced = False

    def close(self) -> None:
        """Write what is held, if it can be, and close the journal."""
        self.flush()
        self._file.close()


def _cut(path: Path) -> None:
    """Cut a journal behind its last complete entry: its writer was killed while it wrote the next."""
    data = path.read_bytes()
    end = max((at for _, at in _entries(data)), default=0)
    if end < len(data):
        os.truncate(path, end)


class SpoolReader:
    """Reads a journal that may grow, and may not be there yet; each message once.

    Args:
        path: of the journal.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._inode, self._offset = 0, 0
        self._first = True

    def new(self) -> Iterator[SpooledMessage]:
        """What was added since the last call, oldest first."""
        old = self._path.with_name(self._path.name + ".old")
        if self._first:
            self._first = False
            yield from self._read(old, 0)
            self._offset = 0
        try:
            inode = self._path.stat().st_ino
        except OSError:
            return
        if inode != self._inode:
            if self._inode and old.exists() and old.stat().st_ino == self._inode:
                yield from self._read(old, self._offset)
            self._inode, self._offset = inode, 0
        yield from self._read(self._path, self._offset)

    def _read(self, path: Path, offset: int) -> Iterator[SpooledMessage]:
        try:
            with path.open("rb") as stream:
                stream.seek(offset)
                data = stream.read()
        except OSError:
            return
        for message, end in _entries(data):
            self._offset = offset + end
            yield message
