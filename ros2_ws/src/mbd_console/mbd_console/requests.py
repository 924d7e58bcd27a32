"""What a browser asks for, validated here once: anything it could send becomes a request or a sentence of refusal."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from mbd_interaction.transitions import TABLE
from mbd_model.correction import CorrectionKind, StepCorrection
from mbd_model.errors import MbdError
from mbd_model.forms.answers import FilledForm
from mbd_model.objects import Role
from mbd_model.session import Phase
from mbd_model.task import StepKind

from mbd_console.actions import ACTIONS, OBJECT_KEYS, Action, offered
from mbd_console.outlines import point_on_table
from mbd_console.state import ConsoleState

NOTE_LENGTH = 500  # characters
LAST_STEP = {Action.DELETE_LAST_STEP: CorrectionKind.DELETE, Action.RERECORD_STEP: CorrectionKind.RERECORD}


class RequestRefusedError(MbdError):
    """A request that cannot be passed on. The text states why and what would be."""


@dataclass(frozen=True)
class Press:
    """A plain action of the table; PAUSE means resume while paused."""

    action: Action


@dataclass(frozen=True)
class AnswerQuestion:
    """The target object handed over (``pointed`` False) or pointed at (True)."""

    object_id: str
    pointed: bool


@dataclass(frozen=True)
class PointAtPlace:
    """A place (x, y, z) [m, robot base frame] pointed at."""

    place: tuple[float, float, float]


@dataclass(frozen=True)
class Overwrite:
    """The target object meant at an earlier step (0-based)."""

    step_index: int
    object_id: str


@dataclass(frozen=True)
class WriteNote:
    """A remark for the bag.

    Attributes:
        text: in whatever words.
        marker: the name of the key, or of the entry of a checklist, that it comes from.
        at: when that was [s, session clock]; None for now.
    """

    text: str
    marker: str = ""
    at: float | None = None


@dataclass(frozen=True)
class SubmitForm:
    """A form that the participant sent in, ``opened`` [s, session clock] when it was shown first."""

    filled: FilledForm
    opened: float


@dataclass(frozen=True)
class BeginSession:
    """The session that the plan has next is to begin in place of the one that is over."""

    session: str


@dataclass(frozen=True)
class CorrectStep:
    """A correction of a demonstrated step."""

    correction: StepCorrection


@dataclass(frozen=True)
class StopRobot:
    """Everything stands until a person resumes: a hand on the stop."""


PublishedRequest = (
    Press | AnswerQuestion | PointAtPlace | Overwrite | WriteNote | CorrectStep | SubmitForm | BeginSession
)
ConsoleRequest = StopRobot | PublishedRequest


def read_request(raw: object, state: ConsoleState, meant_step: int = -1) -> ConsoleRequest:
    """The request in what a browser sent.

    Args:
        raw: a mapping with "action": a value of Action, "object" (with "object_id", or "number" from 1 on, and
            "question") or "place" (with "u", "v" [px] and "question"); a note has "text".
        state: what the pages show now.
        meant_step: the step chosen for "I meant…", -1 for none: the next object overwrites its assist.

    Raises:
        RequestRefusedError: it is none, names what there is not, or answers a question that is no longer asked.
    """
    if not isinstance(raw, Mapping):
        raise RequestRefusedError("the page sent something that is no request; reload it")
    action = raw.get("action")
    if action == "object":
        return _object(raw, state, meant_step)
    if action == "place":
        return _place(raw, state)
    if action == Action.NOTE:
        return WriteNote(_note(raw.get("text")))
    if not isinstance(action, str) or action not in set(Action) - {Action.MEANT}:
        raise RequestRefusedError(f"there is no action {_shown(action)}; there are {', '.join(Action)}")
    wanted = Action(action)
    if not offered(state, wanted):
        raise RequestRefusedError(f"“{ACTIONS[wanted].label()}” is not possible just now: {_why_not(state, wanted)}")
    if wanted in (Action.YES, Action.NO):
        _question_answered(raw, state)
    if wanted in LAST_STEP and state.task is not None:
        return CorrectStep(StepCorrection(LAST_STEP[wanted], len(state.task.steps) - 1))
    return Press(wanted)


def next_meant_step(raw: object, state: ConsoleState, meant_step: int) -> int:
    """The step "I meant…" is about after another press: the one named, else the last assisted one, then earlier ones.

    Returns:
        Its 0-based index, -1 when every choice has been gone through.

    Raises:
        RequestRefusedError: nothing can be corrected, or the step named is none.
    """
    if not offered(state, Action.MEANT) or state.session is None:
        raise RequestRefusedError(f"there is no assist to correct: {_why_not(state, Action.MEANT)}")
    assisted = [a.step_index for a in state.session.assists]
    if state.phase is Phase.EXECUTE:  # a missing assist can be given too, while the robot goes on alone
        known = {a.source_id for a in state.session.assists}
        assisted = [s.index for s in state.steps if s.primary_object not in known] + assisted
    step = raw.get("step") if isinstance(raw, Mapping) else None
    if step is not None:
        if not isinstance(step, int) or isinstance(step, bool) or step not in assisted:
            raise RequestRefusedError(
                f"step {_shown(step)} has no assist to correct; there are {sorted(assisted)} (from 0)"
            )
        return -1 if step == meant_step else step
    at_work = state.progress.step_index if state.progress and state.phase is Phase.EXECUTE else -1
    if at_work in assisted:  # a correction is most often about what the robot is just doing
        assisted = [*(t for t in assisted if t != at_work), at_work]
    if meant_step in assisted:
        place = assisted.index(meant_step)
        return assisted[place - 1] if place else -1
    return assisted[-1] if assisted else -1


def _candidate(raw: Mapping[object, object], state: ConsoleState) -> ConsoleRequest:
    """Which of the two source objects a demonstrated step in doubt was about."""
    number = raw.get("number")
    object_id = raw.get("object_id")
    if isinstance(number, str) and number in OBJECT_KEYS:
        object_id = dict(enumerate(state.candidates, start=1)).get(int(number), number)
    if not isinstance(object_id, str) or object_id not in state.candidates:
        raise RequestRefusedError(f"{_shown(object_id)} is neither of the two: choose {' or '.join(state.candidates)}")
    if state.session is not None and state.session.paused:
        raise RequestRefusedError("the session is paused: resume it first")
    if raw.get("question") != state.question:
        raise RequestRefusedError("the robot asks something else by now: look at the question and answer that")
    return AnswerQuestion(object_id, pointed=True)


def _object(raw: Mapping[object, object], state: ConsoleState, meant_step: int) -> ConsoleRequest:
    if state.candidates:
        return _candidate(raw, state)
    if state.target is None or state.phase not in (Phase.ASSIST, Phase.EXECUTE):
        raise RequestRefusedError("objects are chosen when the robot asks about the new ones, which is not now")
    object_id = raw.get("object_id")
    number = raw.get("number")
    if isinstance(number, str) and len(number) == 1 and number in OBJECT_KEYS:
        place = OBJECT_KEYS.index(number)
        object_id = state.target.ids[place] if place < len(state.target.ids) else number
    if not isinstance(object_id, str) or object_id not in state.target.ids:
        raise RequestRefusedError(f"there is no object {_shown(object_id)}; there are {', '.join(state.target.ids)}")
    if meant_step >= 0:
        return Overwrite(meant_step, object_id)
    asked = _question_answered(raw, state)
    return AnswerQuestion(object_id, asked is StepKind.PLACE)


def _place(raw: Mapping[object, object], state: ConsoleState) -> ConsoleRequest:
    if _question_answered(raw, state) is not StepKind.PLACE:
        raise RequestRefusedError("the robot asks for an object, not for a place: choose an object")
    u, v = raw.get("u"), raw.get("v")
    if not (isinstance(u, int | float) and isinstance(v, int | float) and math.isfinite(u) and math.isfinite(v)):
        raise RequestRefusedError(f"the place {_shown((u, v))} is not two numbers of pixels")
    point = point_on_table(state.view, state.plane(Role.TARGET), (float(u), float(v))) if state.view else None
    if point is None:
        raise RequestRefusedError("there is no table where you pointed: point at the table or choose an object")
    return PointAtPlace(point)


def _question_answered(raw: Mapping[object, object], state: ConsoleState) -> StepKind:
    """The kind of step asked about, when the page showed the question that is asked now."""
    if state.session is not None and state.session.paused:
        raise RequestRefusedError("the session is paused: resume it first")
    asked = state.asked
    if asked is None:
        raise RequestRefusedError("the robot asks nothing just now; “I meant…” corrects an earlier answer")
    if raw.get("question") != state.question:
        raise RequestRefusedError("the robot asks something else by now: look at the question and answer that")
    return asked.kind


def _note(text: object) -> str:
    if not isinstance(text, str):
        raise RequestRefusedError("a note is text")
    # Line breaks and control characters would break the log's lines, here and in whoever reads the bag.
    clean = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    if not clean:
        raise RequestRefusedError("the note is empty: write something first")
    if len(clean) > NOTE_LENGTH:
        raise RequestRefusedError(f"the note has {len(clean)} characters, at most {NOTE_LENGTH} are kept: shorten it")
    return clean


def _why_not(state: ConsoleState, wanted: Action) -> str:
    if state.session is None:
        return "no state of the dialogue was received yet; is the interaction node running?"
    if state.standing:
        return f"everything stands ({state.standing}); make it safe, then resume"
    if state.session.paused:
        return "the session is paused; resume it first"
    phase = state.session.phase
    taken = any((phase, signal) in TABLE for signal in ACTIONS[wanted].signals)
    if taken and wanted in (Action.UNDO, Action.MEANT):
        return "no assist was given yet, or the last one was withdrawn"
    if taken and wanted is Action.START:
        return "a demonstration is being recorded; “End demo” ends it"
    if taken and wanted in (Action.YES, Action.NO) and state.asked is not None:
        return "the robot asks for an object or a place: click it, or press its number"
    if taken and wanted in (Action.YES, Action.NO, Action.SKIP):
        return "the robot asks nothing that it would answer"
    if taken and wanted in (Action.DELETE_LAST_STEP, Action.RERECORD_STEP):
        return "no step is there, or one is being recorded"
    if wanted is Action.NEXT and state.asked is not None:
        return "the robot asks a question: answer it, or skip the step"
    return f"the phase is {phase.name.lower().replace('_', ' ')}, which never takes it"


def _shown(value: object) -> str:
    """A value a browser sent, short enough for a sentence."""
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
