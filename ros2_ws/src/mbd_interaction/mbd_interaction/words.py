"""The operator's words: each by name, with the wizard topic it comes on and what it takes on a command line."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from mbd_model.correction import CorrectionKind
from mbd_model.errors import MbdError
from mbd_model.parameters import nearest
from mbd_model.times import to_nanoseconds

STOP = "stop"  # the robot's, of every node that moves it: no wizard topic


@dataclass(frozen=True)
class SaidWord:
    """What is said with a word; as in Say.srv, ``place`` [m] and ``at`` [ns] besides."""

    object_id: str = ""
    place: tuple[float, float, float] = (0.0, 0.0, 0.0)
    step_index: int = 0
    change: int = 0
    to: int = 0
    at: int = 0
    text: str = ""


Parse = Callable[[Sequence[str]], SaidWord]


def _nothing(given: Sequence[str]) -> SaidWord:
    if given:
        raise MbdError(f"'{given[0]}' is one word too many: it takes nothing")
    return SaidWord()


@dataclass(frozen=True)
class WizardWord:
    """One word.

    Attributes:
        topic: the wizard topic it is published on.
        code: value of the message's field ``command`` or ``answer``; 0 where it has none.
        takes: its arguments, for people; "" for none.
        parse: makes them what is said; raises MbdError when they are no such arguments.
    """

    topic: str
    code: int = 0
    takes: str = ""
    parse: Parse = _nothing


def word_named(name: str) -> WizardWord:
    """The word of that name; raises MbdError with all of them when there is none."""
    if name not in WORDS:
        near = nearest(name, [*WORDS, STOP])
        advice = f"did you mean '{near}'? " if near else ""
        raise MbdError(f"there is no word '{name}'; {advice}there are {', '.join([*WORDS, STOP])}")
    return WORDS[name]


def _object(given: Sequence[str]) -> SaidWord:
    if len(given) != 1 or not given[0]:
        raise MbdError("expected the id of one object, as t3")
    return SaidWord(object_id=given[0])


def _object_or_place(given: Sequence[str]) -> SaidWord:
    if len(given) == 3:
        x, y, z = (_number(v, float, "metres") for v in given)
        return SaidWord(place=(x, y, z))
    return _object(given)


def _overwritten(given: Sequence[str]) -> SaidWord:
    if len(given) != 2:
        raise MbdError("expected the step, counted from 0, and the object meant, as 0 t3")
    return SaidWord(step_index=_step(given[0]), object_id=given[1])


def _note(given: Sequence[str]) -> SaidWord:
    text = " ".join(given)
    if not text:
        raise MbdError("expected the text of the note")
    return SaidWord(text=text)


def _revised(given: Sequence[str]) -> SaidWord:
    kinds = {kind.name.lower(): kind for kind in CorrectionKind}
    if len(given) < 2 or given[0] not in kinds:
        raise MbdError(f"expected one of {', '.join(kinds)} and the step, counted from 0, as delete 2")
    kind, step, rest = kinds[given[0]], _step(given[1]), given[2:]
    wanted = {CorrectionKind.MOVE: 1, CorrectionKind.CHANGE_OBJECT: 1, CorrectionKind.SPLIT: 1}.get(kind, 0)
    if len(rest) != wanted:
        what = {CorrectionKind.MOVE: "the step to go to", CorrectionKind.CHANGE_OBJECT: "the source object"}
        raise MbdError(f"{given[0]} takes {what.get(kind, 'the time [s]') if wanted else 'nothing'} after the step")
    said: dict[str, Any] = {"change": int(kind), "step_index": step}
    if kind is CorrectionKind.MOVE:
        said["to"] = _step(rest[0])
    elif kind is CorrectionKind.CHANGE_OBJECT:
        said["object_id"] = rest[0]
    elif kind is CorrectionKind.SPLIT:
        said["at"] = to_nanoseconds(_number(rest[0], float, "seconds"))
    return SaidWord(**said)


def _step(text: str) -> int:
    step = int(_number(text, int, "a step, counted from 0"))
    if not 0 <= step < 2**32:
        raise MbdError(f"'{text}' is no step: they are counted from 0")
    return step


def _number(text: str, kind: type[float], what: str) -> float:
    try:
        return kind(text)
    except ValueError:
        raise MbdError(f"'{text}' is no number; expected {what}") from None


# Codes are those of the messages.
WORDS: dict[str, WizardWord] = {
    "next_phase": WizardWord("wizard/command", 1),
    "undo": WizardWord("wizard/command", 2),
    "skip": WizardWord("wizard/command", 3),
    "pause": WizardWord("wizard/command", 4),
    "resume": WizardWord("wizard/command", 5),
    "abort": WizardWord("wizard/command", 6),
    "back": WizardWord("wizard/command", 7),
    "redo": WizardWord("wizard/command", 8),
    "start_demonstration": WizardWord("wizard/demonstration", 1),
    "stop_demonstration": WizardWord("wizard/demonstration", 2),
    "open": WizardWord("wizard/gripper", 1),
    "close": WizardWord("wizard/gripper", 2),
    "handed": WizardWord("wizard/handed", 0, "OBJECT", _object),
    "pointed": WizardWord("wizard/pointed", 0, "OBJECT | X Y Z", _object_or_place),
    "yes": WizardWord("wizard/answer", 1),
    "no": WizardWord("wizard/answer", 2),
    "overwrite": WizardWord("wizard/overwrite", 0, "STEP OBJECT", _overwritten),
    "revise": WizardWord("wizard/revision", 0, "CHANGE STEP [TO | OBJECT | AT]", _revised),
    "note": WizardWord("wizard/note", 0, "TEXT", _note),
}
