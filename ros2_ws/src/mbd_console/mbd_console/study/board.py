"""Where a study's own business stands: the form shown, those sent in, what is ticked, the countdown."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from mbd_model.session import Phase

from mbd_console.study.form_plan import PlannedForm


@dataclass(frozen=True)
class StudyBoard:
    """All pages show the same.

    Attributes:
        shown: name of the form on the participant's page, "" for none; ``since``, when it was shown [s, session clock].
        sent: names of the forms sent in, and ``declined``, of those handed back without answers.
        ticked: entries of the checklist that are done, as "PHASE number".
        ends: when the countdown is over [s, session clock]; None while none runs.
    """

    shown: str = ""
    since: float = 0.0
    sent: tuple[str, ...] = ()
    declined: tuple[str, ...] = ()
    ticked: frozenset[str] = frozenset()
    ends: float | None = None

    @property
    def answered(self) -> frozenset[str]:
        """Names of the forms that came back."""
        return frozenset((*self.sent, *self.declined))


NOTHING_YET = StudyBoard()


def show(board: StudyBoard, name: str, at: float) -> StudyBoard:
    """A form is shown from ``at`` [s] on; "" takes it away."""
    return replace(board, shown=name, since=at)


def came_back(board: StudyBoard, name: str, declined: bool) -> StudyBoard:
    """A form was sent in, or handed back."""
    sent = tuple(n for n in board.sent if n != name) + (() if declined else (name,))
    refused = tuple(n for n in board.declined if n != name) + ((name,) if declined else ())
    shown = "" if board.shown == name else board.shown
    return replace(board, sent=sent, declined=refused, shown=shown)


def tick(board: StudyBoard, entry: str) -> StudyBoard:
    """An entry of the checklist is done, or not after all."""
    return replace(board, ticked=board.ticked ^ {entry})


def due(board: StudyBoard, plan: Iterable[PlannedForm], phase: Phase, at: float) -> StudyBoard:
    """With the first form of that phase which did not come back yet, unless one is shown."""
    if board.shown:
        return board
    waiting = (p.form.name for p in plan if p.phase is phase and p.form.name not in board.answered)
    name = next(waiting, "")
    return show(board, name, at) if name else board
