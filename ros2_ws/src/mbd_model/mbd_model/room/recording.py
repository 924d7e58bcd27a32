"""What is kept beside a film of the room: when it began, how its clock stands to the session's, its test signals.

A browser's clock (``performance.now``) counts from when its page was loaded. It is matched to the session's by round
trips: of several the shortest, whose middle is known to half its length.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from mbd_model.errors import MbdError

FORMAT = "mbd room recording 1"
SIGNAL_MARKER = "room_signal"  # of the note in the bag that states when a test signal sounded
MOST_MATCHES, MOST_SIGNALS = 20_000, 2_000
LARGEST_FILE = 4 << 20  # [byte]
MOST_FILMS = 200  # of one session


class RoomError(MbdError):
    """A film of the room, or what lies beside it, that cannot be used."""


def next_film(folder: Path) -> Path | None:
    """A new, empty file ``room_<n>.webm``, by a number that no film had; None when all were used. Raises OSError."""
    for number in range(1, MOST_FILMS + 1):
        path = folder / f"room_{number}.webm"
        if path.with_suffix(".json").exists():
            continue
        try:
            path.open("xb").close()
        except FileExistsError:
            continue
        return path
    return None


@dataclass(frozen=True)
class ClockMatch:
    """One look at both clocks.

    Attributes:
        browser: time [s, the browser's clock].
        session: the same moment [s, session clock].
        uncertainty: [s] by which they may differ: half a round trip.
    """

    browser: float
    session: float
    uncertainty: float


@dataclass(frozen=True)
class RoomSignal:
    """A test signal: a beep and a flash.

    Attributes:
        number: from 1.
        browser: when it began in what is recorded [s, the browser's clock].
        latency: [s] after which the speaker sounds, as the browser states it.
    """

    number: int
    browser: float
    latency: float


@dataclass(frozen=True)
class RoomRecording:
    """Of one file.

    Attributes:
        started: when its time 0 was [s, the browser's clock].
        clock: looks at both clocks, at least one.
        signals: test signals, in order.
        ended: the page closed the file; False while it runs, and for one that broke off.
    """

    started: float
    clock: tuple[ClockMatch, ...]
    signals: tuple[RoomSignal, ...] = ()
    ended: bool = False

    def nearest(self, browser: float) -> ClockMatch:
        """The look at both clocks that was nearest to a moment [s, the browser's clock]."""
        return min(self.clock, key=lambda match: abs(match.browser - browser))

    def session_time(self, browser: float) -> float:
        """A moment of the browser's clock [s] by the session's [s]."""
        match = self.nearest(browser)
        return match.session + (browser - match.browser)


def signal_words(name: str, number: int) -> str:
    """The text of the note that marks a test signal in the bag; ``name``: of the file, without ending."""
    return f"{name} {number}"


def room_recording(raw: object) -> RoomRecording:
    """The recording that a page or a file states.

    Args:
        raw: a mapping with "started" [s], "clock": lists of browser [s], session [s], uncertainty [s]; "signals":
            lists of number, browser [s], latency [s]; "ended".

    Raises:
        RoomError: it is none; the text names the field.
    """
    read = raw if isinstance(raw, Mapping) else {}
    clock = tuple(ClockMatch(*row) for row in _rows(read, "clock", MOST_MATCHES))
    signals = tuple(RoomSignal(int(row[0]), row[1], row[2]) for row in _rows(read, "signals", MOST_SIGNALS))
    if not clock:
        raise RoomError("clock is empty; expected at least one look at both clocks")
    if any(match.uncertainty < 0 for match in clock):
        raise RoomError("clock has an uncertainty below 0; expected half a round trip [s]")
    if [signal.number for signal in signals] != list(range(1, len(signals) + 1)):
        raise RoomError("signals are not numbered 1, 2, 3, ...")
    return RoomRecording(_number(read.get("started"), "started"), clock, signals, read.get("ended") is True)


def _rows(read: Mapping[Any, Any], name: str, most: int) -> list[tuple[float, float, float]]:
    rows = read.get(name)
    if not isinstance(rows, Sequence) or isinstance(rows, str | bytes) or len(rows) > most:
        raise RoomError(f"{name} is no list of at most {most}")
    if any(not isinstance(row, Sequence) or isinstance(row, str | bytes) or len(row) != 3 for row in rows):
        raise RoomError(f"{name} has an entry that is no list of three numbers")
    return [(_number(a, name), _number(b, name), _number(c, name)) for a, b, c in rows]


def _number(value: object, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value) or abs(value) > 1e12:
        raise RoomError(f"{name} has {str(value)[:40]!r}; expected a number [s]")
    return float(value)


def as_text(recording: RoomRecording, file: str) -> str:
    """What is written beside a film; ``file``: its name. ``start``: of the film's time 0 by the session's clock."""
    match = recording.nearest(recording.started)
    start = {"session_time_s": recording.session_time(recording.started), "uncertainty_s": match.uncertainty}
    kept = {
        "format": FORMAT,
        "file": file,
        "start": start,
        "started": recording.started,
        "clock": [list(asdict(match).values()) for match in recording.clock],
        "signals": [list(asdict(signal).values()) for signal in recording.signals],
        "ended": recording.ended,
    }
    return json.dumps(kept, indent=1) + "\n"


def read_room_recording(path: Path) -> RoomRecording:
    """The recording that a file states; raises RoomError naming the file when it states none."""
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise RoomError(f"it has more than {LARGEST_FILE} bytes")
        raw = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(raw, dict) or raw.get("format") != FORMAT:
            raise RoomError(f"it is no file of the format '{FORMAT}'")
        return room_recording(raw)
    except (OSError, ValueError, RecursionError) as error:
        raise RoomError(f"{path} cannot be used: {error}; expected what the console wrote beside the film") from error
