"""Films of the room as files: begun, grown chunk by chunk, never overwritten, each a playable file at any moment."""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
import shutil
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from mbd_model.room.recording import MOST_FILMS, RoomRecording, RoomSignal, as_text, next_film

from mbd_console.room.refusal import RoomRefusedError
from mbd_console.room.shown import ShownFilm

LARGEST_CHUNK = 8 << 20  # [byte]; one holds a second
LARGEST_RATE = 96 << 20  # [byte] a minute, of one film
MOST_OPEN = 4  # films that grow at once
RESERVED = 1e9  # [byte] that the session's own recording keeps to itself
ABANDONED = 60.0  # [s] without a chunk after which a film counts no longer as open
WEBM = b"\x1a\x45\xdf\xa3"  # how every WebM file begins


@dataclass
class OpenFilm:
    """A film that grows.

    Attributes:
        path: of the file.
        key: that its page has, so that no other page writes into it.
        last: when something came last [s, steady clock].
        chunks, size: taken so far, and their bytes.
        recent: (when, bytes) of the last minute.
        marked: test signals that were published.
        closed: its page ended it.
        refused: why nothing more is taken, "" while it is.
        sound, picture: whether its page has them.
    """

    path: Path
    key: str
    last: float
    chunks: int = 0
    size: int = 0
    recent: deque[tuple[float, int]] = field(default_factory=deque)
    marked: int = 0
    closed: bool = False
    refused: str = ""
    sound: bool = True
    picture: bool = True


class RoomStore:
    """The films of one session.

    Args:
        folder: beside the bag; None where it is not known.
        clock: [s], steady.
        free: [byte] left on the folder's disk.

    Attributes:
        shown: the films that grow, or were meant to; replaced as a whole, so that any thread may read it.
    """

    def __init__(
        self,
        folder: Path | None,
        clock: Callable[[], float],
        free: Callable[[Path], float] = lambda folder: float(shutil.disk_usage(folder).free),
    ) -> None:
        self.folder, self._clock, self._free = folder, clock, free
        self.shown: tuple[ShownFilm, ...] = ()
        self._films: dict[str, OpenFilm] = {}
        self._lock = threading.Lock()

    def begin(self, *, sound: bool = True, picture: bool = True) -> tuple[str, str]:
        """Name and key of a new, empty film.

        Args:
            sound: whether its page has a microphone.
            picture: whether it has a camera.

        Raises:
            RoomRefusedError: there can be none.
        """
        with self._lock:
            folder = self._usable()
            for film in self._films.values():
                if film.refused or self._clock() - film.last > ABANDONED:
                    film.closed = True  # its page is gone, or was refused: what it has stays
            if sum(not film.closed for film in self._films.values()) >= MOST_OPEN:
                raise RoomRefusedError("room_many", 409, most=MOST_OPEN)
            try:
                path = next_film(folder)
            except OSError as error:
                raise _unwritable(error) from error
            if path is None:
                raise RoomRefusedError("room_many", 409, most=MOST_FILMS)
            self._films[path.stem] = OpenFilm(path, secrets.token_hex(16), self._clock(), sound=sound, picture=picture)
            self._show()
            return path.stem, self._films[path.stem].key

    def append(self, name: str, key: str, number: int, data: bytes) -> int:
        """Add a chunk; one that came already is not added again.

        Args:
            name: of the film.
            key: of the film.
            number: of the chunk, from 0.
            data: its bytes.

        Returns:
            Bytes of the film.

        Raises:
            RoomRefusedError: it is not taken; the film stays as it is.
        """
        with self._lock:
            film = self._film(name, key)
            now = self._clock()
            if film.refused:
                raise RoomRefusedError(film.refused, 409)
            if number < film.chunks:
                return film.size
            if number > film.chunks:
                raise RoomRefusedError("room_gap", 409)
            if len(data) > LARGEST_CHUNK:
                raise RoomRefusedError("room_large", 413, most=LARGEST_CHUNK >> 20)
            if number == 0 and not data.startswith(WEBM):
                raise RoomRefusedError("room_not_webm", 415)
            while film.recent and now - film.recent[0][0] > 60.0:
                film.recent.popleft()
            if sum(size for _, size in film.recent) + len(data) > LARGEST_RATE:
                raise RoomRefusedError("room_fast", 429)
            try:
                self._usable()
                self._write(film, data)
            except RoomRefusedError as refusal:
                film.refused = refusal.text
                self._show()
                raise
            film.recent.append((now, len(data)))
            film.last, film.chunks, film.size = now, film.chunks + 1, film.size + len(data)
            self._show()
            return film.size

    def keep(self, name: str, key: str, recording: RoomRecording) -> tuple[RoomSignal, ...]:
        """Write down what is to lie beside a film; the test signals in it that are not marked in the bag yet.

        Raises:
            RoomRefusedError: it cannot be written.
        """
        with self._lock:
            film = self._film(name, key)
            beside = film.path.with_suffix(".json")
            made = beside.with_suffix(".json.new")
            try:
                made.write_text(as_text(recording, film.path.name), encoding="utf-8")
                made.replace(beside)
            except OSError as error:
                raise _unwritable(error) from error
            film.closed = film.closed or recording.ended
            self._show()
            return recording.signals[film.marked :]

    def mark(self, name: str, number: int) -> None:
        """A film's test signals up to this one are marked in the bag."""
        self._films[name].marked = number

    def why_not(self) -> RoomRefusedError | None:
        """Why no film can be begun or go on; None when it can."""
        try:
            self._usable()
        except RoomRefusedError as refusal:
            return refusal
        return None

    def _show(self) -> None:
        self.shown = tuple(
            ShownFilm(f.path.stem, f.last, f.refused, sound=f.sound, picture=f.picture)
            for f in self._films.values()
            if not f.closed
        )

    def _usable(self) -> Path:
        folder = self.folder
        if folder is None or not folder.is_dir():
            raise RoomRefusedError("room_no_folder", 409)
        try:
            left = self._free(folder)
        except OSError as error:
            raise _unwritable(error) from error
        if left < RESERVED:
            raise RoomRefusedError("room_full", 507)
        return folder

    def _film(self, name: str, key: str) -> OpenFilm:
        film = self._films.get(name)
        if film is None or film.closed or not secrets.compare_digest(film.key.encode(), key.encode()):
            raise RoomRefusedError("room_unknown", 404)
        return film

    def _write(self, film: OpenFilm, data: bytes) -> None:
        """Append all of it or nothing; what is amid the file is not touched."""
        try:
            with film.path.open("r+b") as stream:
                stream.seek(film.size)
                try:
                    stream.write(data)
                    stream.flush()
                except OSError:
                    with contextlib.suppress(OSError):
                        os.ftruncate(stream.fileno(), film.size)
                    raise
        except OSError as error:
            raise _unwritable(error) from error


def _unwritable(error: OSError) -> RoomRefusedError:
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        return RoomRefusedError("room_full", 507)
    return RoomRefusedError("room_unwritable", 409)
