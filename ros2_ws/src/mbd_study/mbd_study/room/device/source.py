"""A camera or microphone that FFmpeg opens, read in a thread of its own; each frame with when it was taken."""

from __future__ import annotations

import os
import queue
import threading
import time
from collections import deque
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

from mbd_model.room.recording import RoomError

FORMATS = {"video": "v4l2", "audio": "alsa"}
# PyAV's wheel looks for ALSA's configuration where it was built.
_ALSA, _ALSA_FILE = "ALSA_CONFIG_PATH", Path("/usr/share/alsa/alsa.conf")
_WALL_CLOCK = 10.0  # [s] within which a stamp that counts from 1970 is taken for one
_SETTLING = 100  # frames over which the shortest way from device to here is looked for
WAITING = 400  # frames that wait at most: some seconds


@dataclass(frozen=True)
class TakenFrame:
    """A frame of PyAV, of "video" or "audio", and when it was taken [s, steady clock]; of sound its first sample."""

    kind: str
    at: float
    frame: Any


@dataclass(frozen=True)
class SourceEnd:
    """A device gives no more; ``why``: in words."""

    why: str


def require_av() -> ModuleType:
    """PyAV; raises RoomError when it is not installed."""
    try:
        import av
    except ImportError as error:
        raise RoomError("PyAV, which films, is missing: pip install av (requirements/recordings.txt)") from error
    return av


class FrameClock:
    """When frames were taken, by the stamps of their device.

    Stamps that count from 1970 are the system's clock. Of others the first is unknown: the frame that came here the
    fastest says where they begin, so that a busy machine moves nothing.
    """

    def __init__(self) -> None:
        self._starts: deque[float] = deque(maxlen=_SETTLING)

    def taken(self, stamp: float, long: float, came: float, wall: float) -> float:
        """When a frame was taken [s, steady clock].

        Args:
            stamp: of the frame [s, whatever its device counts from].
            long: how long it lasts [s]; of a picture 0.
            came: when it came here [s, steady clock].
            wall: the same moment [s since 1970].
        """
        if abs(stamp - wall) < _WALL_CLOCK:
            return came + (stamp - wall)
        self._starts.append(came - long - stamp)
        return min(self._starts) + stamp


class DeviceSource:
    """Reads a device until it ends or `stop` is called.

    Args:
        kind: "video" or "audio".
        device: its name: /dev/video0, hw:0; of another FFmpeg format with that before it: "lavfi:testsrc".
        frames: where they go, and in the end a `SourceEnd`.
        options: of FFmpeg's format.

    Attributes:
        dropped: frames for which there was no room.

    Raises:
        RoomError: it cannot be opened, or gives no such thing; the text names it.
    """

    def __init__(
        self, kind: str, device: str, frames: queue.Queue[TakenFrame | SourceEnd], options: dict[str, str] | None = None
    ) -> None:
        av = require_av()
        form, name = FORMATS[kind], device
        before, colon, after = device.partition(":")
        if colon and before in ("v4l2", "alsa", "lavfi", "x11grab", "oss"):
            form, name = before, after
        if form == "alsa" and _ALSA not in os.environ and _ALSA_FILE.exists():
            os.environ[_ALSA] = str(_ALSA_FILE)
        self.kind, self.device, self.dropped = kind, device, 0
        self._frames, self._stopped, self._errors = frames, threading.Event(), (av.FFmpegError, OSError)
        try:
            self._container = av.open(name, format=form, options=options or {})
        except (*self._errors, ValueError) as error:
            why = getattr(error, "strerror", None) or str(error)
            raise RoomError(
                f"{device} cannot be opened as {kind} by FFmpeg's {form}: {why}; expected "
                + ("a camera such as /dev/video0" if kind == "video" else "a microphone such as hw:0 (arecord -l)")
            ) from error
        streams = self._container.streams.video if kind == "video" else self._container.streams.audio
        if not streams:
            self._container.close()
            raise RoomError(f"{device} gives no {kind}; give another device")
        self._stream: Any = streams[0]
        self._thread = threading.Thread(target=self._read, daemon=True)

    def start(self) -> None:
        """Begin to read."""
        self._thread.start()

    def stop(self) -> None:
        """Read no more; a device that hangs is left to its thread."""
        self._stopped.set()
        if self._thread.is_alive():
            self._thread.join(1.0)

    def _read(self) -> None:
        clock = FrameClock()
        why = f"{self.device} gives no more {self.kind}"
        try:
            for packet in self._container.demux(self._stream):
                came, wall = time.monotonic(), time.time()
                for frame in packet.decode():
                    if frame.pts is None or frame.time_base is None:
                        continue
                    long = frame.samples / frame.sample_rate if self.kind == "audio" else 0.0
                    taken = clock.taken(float(frame.pts * frame.time_base), long, came, wall)
                    try:
                        self._frames.put_nowait(TakenFrame(self.kind, taken, frame))
                    except queue.Full:
                        self.dropped += 1
                if self._stopped.is_set():
                    break
        except self._errors as error:
            why = f"{self.device} is lost: {getattr(error, 'strerror', None) or error}"
        finally:
            self._container.close()
        if not self._stopped.is_set():
            self._frames.put(SourceEnd(why))
