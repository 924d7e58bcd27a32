"""A film of the room from devices: begun, told apart from the others beside a bag, its clock and signals kept."""

from __future__ import annotations

import queue
import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from mbd_model.room.device_report import DeviceReport
from mbd_model.room.recording import MOST_FILMS, ClockMatch, RoomError, RoomRecording, RoomSignal, as_text, next_film

from mbd_study.room.device.film_file import FilmFile
from mbd_study.room.device.source import WAITING, DeviceSource, SourceEnd, TakenFrame

RESERVED = 1e9  # [byte] that the session's own recording keeps to itself
SILENT = 5.0  # [s] without a frame after which a device counts as lost
OPENING = 10.0  # [s] until a device that was opened has to give something
LOOK_EVERY = 10.0  # [s] between two looks at both clocks
SIGNAL_EVERY = 300.0  # [s]
REPORT_EVERY = 1.0  # [s]
_SOON = 0.3  # [s] from now to a test signal: what of the sound was written already is nearer
_BETWEEN = 2.0  # [s] between two test signals at least, so that each is found where it ought to be
_AFTER_LAST = 0.9  # [s] that is recorded after the begin of the last test signal


class FilmedSession(Protocol):
    """What of the session a film needs."""

    def look(self) -> ClockMatch:
        """Both clocks at one moment; the steady one stands where a browser's would."""

    def mark(self, name: str, number: int, at: float) -> None:
        """Mark a test signal in the bag; ``at``: [s, session clock]."""

    def report(self, report: DeviceReport) -> None:
        """Say on the session's pages how the film stands."""


@dataclass(frozen=True)
class FilmEnd:
    """How a film ended; ``lost``: why a device or the disk ended it, "" when it was to end; ``dropped``: frames."""

    path: Path
    seconds: float
    signals: int
    dropped: int
    lost: str


@dataclass
class RoomDevices:
    """Films with a camera, a microphone, or both.

    Attributes:
        folder: beside the bag.
        sources: at least one.
        frames: to which the sources give.
        session: for its clock and its bag.
        stopped: whether to end.
    """

    folder: Path
    sources: tuple[DeviceSource, ...]
    frames: queue.Queue[TakenFrame | SourceEnd]
    session: FilmedSession
    stopped: Callable[[], bool]
    _clock: list[ClockMatch] = field(default_factory=list)
    _signals: list[RoomSignal] = field(default_factory=list)
    _reported: float = 0.0

    def film(self, begun: Callable[[Path], None]) -> FilmEnd:
        """Film until told to end, or until a device is lost; returns how it ended.

        Args:
            begun: is told the file's name.

        Raises:
            RoomError: no device gives anything, or no file can be begun.
        """
        _require_space(self.folder)
        for source in self.sources:
            source.start()
        try:
            first = self._first_of_each()
            path = new_film(self.folder)
            begun(path)
            return self._grow(path, first)
        finally:
            for source in self.sources:
                source.stop()

    def _first_of_each(self) -> dict[str, TakenFrame]:
        """The first frame of each kind: the film begins when all devices give something."""
        found: dict[str, TakenFrame] = {}
        end = time.monotonic() + OPENING
        while len(found) < len(self.sources):
            try:
                item = self.frames.get(timeout=max(end - time.monotonic(), 0.001))
            except queue.Empty:
                missing = next(s.device for s in self.sources if s.kind not in found)
                raise RoomError(
                    f"{missing} gave nothing within {OPENING:.0f} s; is it used by another program?"
                ) from None
            if isinstance(item, SourceEnd):
                raise RoomError(f"{item.why}; nothing was recorded")
            found.setdefault(item.kind, item)
        return found

    def _grow(self, path: Path, first: dict[str, TakenFrame]) -> FilmEnd:
        started = max(item.at for item in first.values())
        picture = first.get("video")
        size = None if picture is None else (picture.frame.width, picture.frame.height)
        film = FilmFile(path, started, size, sound="audio" in first)
        last = dict.fromkeys(first, time.monotonic())
        self._look()
        self._reported = -REPORT_EVERY
        next_signal, next_look, end, why = started + 1.0, started + LOOK_EVERY, float("inf"), ""
        try:
            while time.monotonic() < end and not why:
                now = time.monotonic()
                self._report(path, first, now)
                if self.stopped() and end == float("inf"):
                    next_signal, end = float("inf"), now
                    if "audio" in first:
                        end = self._signal(film, path) + _AFTER_LAST
                if now >= next_signal and "audio" in first:
                    self._signal(film, path)
                    next_signal = now + SIGNAL_EVERY
                if now >= next_look:
                    self._look()
                    self._keep(path, started, ended=False)
                    next_look = now + LOOK_EVERY
                    why = _full(self.folder)
                why = why or self._take(film, last)
        except BaseException as error:
            why = why or f"{type(error).__name__}: {error}"
            raise
        finally:
            # Said first: what follows may fail on a full disk, and nobody should go on believing that it films.
            self._report(path, first, float("inf"), ended=not why, lost=why)
            film.close()
            self._look()
            self._keep(path, started, ended=True)
        dropped = sum(source.dropped for source in self.sources)
        return FilmEnd(path, time.monotonic() - started, len(self._signals), dropped, why)

    def _report(
        self, path: Path, first: dict[str, TakenFrame], now: float, *, ended: bool = False, lost: str = ""
    ) -> None:
        """Say on the session's pages that it films, once a second, and in the end that it does no longer."""
        if now - self._reported >= REPORT_EVERY:
            self._reported = now
            self.session.report(DeviceReport(path.stem, "audio" in first, "video" in first, ended, lost))

    def _take(self, film: FilmFile, last: dict[str, float]) -> str:
        """Write the next frame; why there are no more, "" while there are."""
        try:
            item = self.frames.get(timeout=0.05)
        except queue.Empty:
            item = None
        now = time.monotonic()
        if isinstance(item, SourceEnd):
            return item.why
        if item is not None:
            last[item.kind] = now
            try:
                film.add_sound(item) if item.kind == "audio" else film.add_picture(item)
            except OSError as error:
                return f"the film cannot be written: {error.strerror or error}"
        silent = next((s.device for s in self.sources if now - last[s.kind] > SILENT), None)
        return "" if silent is None else f"{silent} gave nothing for {SILENT:.0f} s"

    def _signal(self, film: FilmFile, path: Path) -> float:
        """Mix a test signal into the film, and mark it in the bag; when it begins [s, steady clock]."""
        at = time.monotonic() + _SOON
        if self._signals:
            at = max(at, self._signals[-1].browser + _BETWEEN)
        match = self._look()
        film.signal(at)
        self._signals.append(RoomSignal(len(self._signals) + 1, at, 0.0))
        self.session.mark(path.stem, len(self._signals), match.session + (at - match.browser))
        return at

    def _look(self) -> ClockMatch:
        self._clock.append(self.session.look())
        return self._clock[-1]

    def _keep(self, path: Path, started: float, *, ended: bool) -> None:
        """Write what lies beside the film; a disk that takes nothing ends no film."""
        recording = RoomRecording(started, tuple(self._clock), tuple(self._signals), ended)
        beside = path.with_suffix(".json")
        made = beside.with_suffix(".json.new")
        made.write_text(as_text(recording, path.name), encoding="utf-8")
        made.replace(beside)


def new_film(folder: Path) -> Path:
    """A new, empty file ``room_<n>.webm``, by numbers that no film had; raises RoomError."""
    try:
        path = next_film(folder)
    except OSError as error:
        raise RoomError(f"{folder} takes no film: {error.strerror}; give the folder of a session") from error
    if path is None:
        raise RoomError(f"{folder} has {MOST_FILMS} films already; move some away")
    return path


def waiting_frames() -> queue.Queue[TakenFrame | SourceEnd]:
    """Where devices put their frames."""
    return queue.Queue(WAITING)


def _full(folder: Path) -> str:
    return "" if shutil.disk_usage(folder).free >= RESERVED else "the disk has less than 1 GB left"


def _require_space(folder: Path) -> None:
    if why := _full(folder):
        raise RoomError(f"{why}, which the session's own recording keeps to itself: make room")
