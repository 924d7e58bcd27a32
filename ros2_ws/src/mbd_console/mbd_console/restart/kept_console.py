"""What of the console survives its restart: the session's clock, the study's board, the photographs of the scenes."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
from mbd_model.folders import set_aside
from mbd_model.objects import Role

from mbd_console.pictures import Picture
from mbd_console.state import ConsoleState
from mbd_console.study.board import StudyBoard

QUALITY = 92  # of JPEG, of 100


class _Kept(NamedTuple):
    """What console.json holds: of which session, when it and its phase began [s], and the board."""

    session: str
    phase: str
    began: float
    phase_began: float
    board: StudyBoard


@dataclass(frozen=True)
class KeptConsole:
    """Files in ``folder``: console.json, and a JPEG for each scene with its stamp [s] in the name.

    What cannot be read is set aside: nothing of it is needed to lead a session.
    """

    folder: Path

    def keep(self, state: ConsoleState) -> None:
        """Write the clock and the board; raises OSError when that cannot be."""
        session, board = state.session, state.study
        if session is None:
            return
        kept = {
            "session": session.session,
            "phase": session.phase.name,
            "began": state.began,
            "phase_began": state.phase_began,
            "shown": board.shown,
            "since": board.since,
            "sent": list(board.sent),
            "declined": list(board.declined),
            "ticked": sorted(board.ticked),
            "ends": board.ends,
        }
        _write(self._file, json.dumps(kept, ensure_ascii=False).encode())

    def restored(self, state: ConsoleState) -> tuple[float, float, StudyBoard] | None:
        """When the session and its phase began [s] and the board, for the session that ``state`` is of; else None."""
        try:
            kept = self._read()
        except OSError:
            return None
        if state.session is None or kept.session != state.session.session:
            return None
        same = kept.phase == state.session.phase.name
        return kept.began, kept.phase_began if same else state.phase_began, kept.board

    def set_aside_unreadable(self) -> str:
        """Move what is no file of a console out of the way; returns a sentence on it, "" when all is well."""
        try:
            self._read()
        except FileNotFoundError:
            return ""
        except OSError as error:
            return f"{self._file} is not what a console keeps ({error}). {set_aside(self._file)}"
        return ""

    @property
    def _file(self) -> Path:
        return self.folder / "console.json"

    def _read(self) -> _Kept:
        """The file; raises OSError when it is none, or another's."""
        try:
            kept: dict[str, Any] = json.loads(self._file.read_text(encoding="utf-8"))
            board = StudyBoard(
                str(kept["shown"]),
                float(kept["since"]),
                tuple(str(n) for n in kept["sent"]),
                tuple(str(n) for n in kept["declined"]),
                frozenset(str(n) for n in kept["ticked"]),
                None if kept["ends"] is None else float(kept["ends"]),
            )
            return _Kept(
                str(kept["session"]), str(kept["phase"]), float(kept["began"]), float(kept["phase_began"]), board
            )
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError, OverflowError) as error:
            raise OSError(f"{type(error).__name__}: {error}"[:200]) from error

    def keep_picture(self, role: Role, stamp: float, picture: Picture) -> None:
        """Write the photograph, (height, width, 3) RGB, of the scene stamped so [s]; raises OSError."""
        ok, data = cv2.imencode(".jpg", picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
        if ok:
            _write(self._photograph(role, stamp), data.tobytes())
            for other in self.folder.glob(f"console_{role}_*.jpg"):
                if other != self._photograph(role, stamp):
                    other.unlink(missing_ok=True)

    def picture(self, role: Role, stamp: float) -> Picture | None:
        """The photograph of the scene stamped so [s], None when none was kept."""
        try:
            data = np.frombuffer(self._photograph(role, stamp).read_bytes(), np.uint8)
            found = cv2.imdecode(data, cv2.IMREAD_COLOR)
        except (OSError, cv2.error):
            return None
        return None if found is None else np.asarray(found[..., ::-1], np.uint8)

    def _photograph(self, role: Role, stamp: float) -> Path:
        return self.folder / f"console_{role}_{stamp:.6f}.jpg"


def _write(path: Path, data: bytes) -> None:
    """All of it or nothing: a console may be killed while it writes."""
    part = path.with_suffix(".part")
    part.write_bytes(data)
    part.replace(path)
