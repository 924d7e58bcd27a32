"""Everything an operator can do on the console, each with its key and its words."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from mbd_interaction.events import Signal
from mbd_interaction.transitions import TABLE
from mbd_model.session import Awaited, Phase

from mbd_console.state import ConsoleState
from mbd_console.words.texts import ENGLISH, PageTexts


class Action(StrEnum):
    """What a button or a key does."""

    NEXT = "next"
    START = "start"
    STOP = "stop"
    OPEN = "open"
    CLOSE = "close"
    UNDO = "undo"
    SKIP = "skip"
    MEANT = "meant"
    YES = "yes"
    NO = "no"
    PAUSE = "pause"
    BACK = "back"
    REDO = "redo"
    ABORT = "abort"
    DELETE_LAST_STEP = "delete_last_step"
    RERECORD_STEP = "rerecord_step"
    NOTE = "note"


@dataclass(frozen=True)
class ActionSpec:
    """How an action looks.

    Attributes:
        action: which.
        key: what the keyboard sends for it (KeyboardEvent.key); upper case where Shift is wanted.
        signals: the dialogue's events, any of which it sends; () when it is not the dialogue's business.
        confirm: asked for twice, because it cannot be taken back.
    """

    action: Action
    key: str
    signals: tuple[Signal, ...] = ()
    confirm: bool = False

    def label(self, texts: PageTexts = ENGLISH) -> str:
        """On its button."""
        return texts(f"do_{self.action}")

    def hint(self, texts: PageTexts = ENGLISH) -> str:
        """A sentence for its tooltip."""
        return texts(f"tip_{self.action}")

    @property
    def key_label(self) -> str:
        """The key as it is written on the button."""
        return f"⇧{self.key}" if self.key.isupper() else self.key.upper()


ACTIONS: dict[Action, ActionSpec] = {
    s.action: s
    for s in (
        ActionSpec(Action.NEXT, "n", (Signal.NEXT_PHASE,)),
        ActionSpec(Action.START, "s", (Signal.START,)),
        ActionSpec(Action.STOP, "e", (Signal.STOP,)),
        ActionSpec(Action.OPEN, "o", (Signal.GRIPPER,)),
        ActionSpec(Action.CLOSE, "c", (Signal.GRIPPER,)),
        ActionSpec(Action.YES, "y", (Signal.YES,)),
        ActionSpec(Action.NO, "w", (Signal.NO,)),
        ActionSpec(Action.UNDO, "u", (Signal.UNDO,)),
        ActionSpec(Action.SKIP, "k", (Signal.SKIP,)),
        ActionSpec(Action.MEANT, "m", (Signal.OVERWRITE,)),
        ActionSpec(Action.PAUSE, "p", (Signal.PAUSE, Signal.RESUME)),
        ActionSpec(Action.BACK, "b", (Signal.BACK,), confirm=True),
        ActionSpec(Action.REDO, "r", (Signal.REDO,), confirm=True),
        ActionSpec(Action.ABORT, "X", (Signal.ABORT,), confirm=True),
        ActionSpec(Action.DELETE_LAST_STEP, "d", (Signal.REVISE,)),
        ActionSpec(Action.RERECORD_STEP, "l", (Signal.REVISE,)),
        ActionSpec(Action.NOTE, "t", (Signal.NOTE,)),
    )
}
KEYS: dict[str, Action] = {spec.key: action for action, spec in ACTIONS.items()}
# Which answers a question that names target objects takes, besides an object.
NAMING: dict[Awaited, tuple[Action, ...]] = {
    Awaited.CONFIRMATION: (Action.YES, Action.NO),
    Awaited.YES_OR_NO: (Action.YES, Action.NO),
    Awaited.ONE_OF_TWO: (Action.NO,),
    Awaited.HELP: (Action.YES, Action.NO),
    Awaited.EXECUTION: (Action.NO,),
}
# Target objects are chosen by number, in the order of the scene.
OBJECT_KEYS = "123456789"


def offered(state: ConsoleState, action: Action) -> bool:
    """Whether an action makes sense now; the dialogue has the last word and states why when it refuses."""
    if action in (Action.OPEN, Action.CLOSE, Action.NOTE):
        return action is Action.NOTE or not state.standing
    session = state.session
    if session is None:
        return False
    if action is Action.PAUSE and (state.standing or session.phase in (Phase.DONE, Phase.ABORTED)):
        # It resumes then, also after the session; and takes an abort back.
        return bool(state.standing) or session.phase is Phase.ABORTED
    taken = any((session.phase, signal) in TABLE for signal in ACTIONS[action].signals)
    if not taken or (session.paused and action not in (Action.PAUSE, Action.ABORT)):
        return False
    if action is Action.START:
        return not state.recording
    if action in (Action.DELETE_LAST_STEP, Action.RERECORD_STEP):
        shown = session.phase in (Phase.DEMONSTRATE, Phase.TUCK_AND_CLEAR) and bool(state.task and state.task.steps)
        return shown and not state.recording
    if action in (Action.UNDO, Action.MEANT):
        return bool(session.assists) or (action is Action.MEANT and session.phase is Phase.EXECUTE)
    if action in (Action.YES, Action.NO):
        return action in NAMING.get(session.awaiting, ())
    if action is Action.SKIP and session.phase is Phase.TUCK_AND_CLEAR:
        return bool(state.candidates)
    return action is not Action.SKIP or session.step_index >= 0
