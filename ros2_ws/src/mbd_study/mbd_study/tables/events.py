"""Everything that happened in a session, one row each, in true order: asked, answered, refused, noted, estimated.

The order is that of the bag's log times; of equal ones (a simulated clock is coarse) that of the messages' own stamps.
A reply that the recorder received before the word it answers comes after that word.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from mbd_bag.formats.contents import BagMessage
from mbd_bag.storage.bag import Bag
from mbd_model.session import Phase, PromptKind
from mbd_model.times import to_seconds

PROMPT, REPLY, STATE = "interaction/prompt", "interaction/replies", "interaction/state"
ESTIMATE, SPEECH, STOP, FORM = "mapping/estimate", "cell/speech", "stop", "study/form"
_KINDS = {
    PROMPT: "prompt",
    REPLY: "reply",
    STATE: "phase",
    ESTIMATE: "estimate",
    SPEECH: "speech",
    STOP: "stop",
    FORM: "form",
}
_SERVICE = "/_service_event"
# A word without a stamp that was recorded this much after its reply is still taken for its word [ns].
_SOON = 1_000_000_000
# Fields of a word that hold a constant of its message, and those that name objects.
_CHOICES = ("command", "answer", "change", "word", "cause")
_OBJECTS = ("object_id", "object")
ANSWERS = frozenset({"handed", "pointed", "answer"})
# The operator's marker for "now": it parts an answer's latency into the teacher's and the operator's.
TEACHER_ACTS = "teacher_acts"
# What the scripted operator enters when the simulated teacher has said a word.
_SPOKEN = {"open": "open", "close": "close", "demonstration_begins": "start", "demonstration_ends": "stop"}


@dataclass(frozen=True)
class EventRow:
    """One event; `data_dictionary` states what each column holds.

    ``latency_s``: of an answer since its question, of a reply since its word, of a word since the teacher's speech;
    None where there is no such event. ``teacher_latency_s``, ``wizard_latency_s``: where it is known who took how long.
    """

    session: str
    event: int
    time_s: float
    phase: str
    kind: str
    topic: str
    name: str
    step: int | None
    source: str
    target: str
    text: str
    accepted: bool | None
    cause: int | None
    latency_s: float | None
    teacher_latency_s: float | None = None
    wizard_latency_s: float | None = None


@dataclass(frozen=True)
class _Received:
    """One message: its topic without namespace, its own stamp [ns] (0: none), when it was recorded [ns]."""

    topic: str
    stamp: int
    time: int
    message: Any


def event_topics(bag: Bag) -> dict[str, str]:
    """The topics that events are made of, each with its last words, so that a namespace does not matter."""
    found: dict[str, str] = {}
    for topic in bag.topics:
        if not topic.count:
            continue
        words = topic.name.strip("/").split("/")
        last = "/".join(words[-2:])
        if topic.name.endswith(_SERVICE):
            found[topic.name] = topic.name
        elif topic.msgtype.startswith("mbd_msgs/") and (
            last in _KINDS or words[-1] in _KINDS or (len(words) > 1 and words[-2] == "wizard")
        ):
            found[topic.name] = last if last in _KINDS or words[-2:-1] == ["wizard"] else words[-1]
    return found


def event_rows(bag: Bag, session: str) -> tuple[EventRow, ...]:
    """The events of a bag.

    Args:
        bag: of the session.
        session: its name.

    Raises:
        BagError: a message cannot be decoded.
    """
    topics = event_topics(bag)
    received = [_received(topics[m.topic], m, decoded) for m, decoded in bag.decoded(set(topics))] if topics else []
    received.sort(key=lambda one: (one.time, one.stamp or one.time))
    rows: list[EventRow] = []
    phase = ""
    question: EventRow | None = None
    acted: EventRow | None = None
    spoken: EventRow | None = None
    words: dict[int, EventRow] = {}
    for one, word in _causal(received):
        row = _row(one, session, len(rows), to_seconds(one.time - bag.start))
        if row.kind == "phase":
            if row.name == phase:
                continue
            phase = row.name
        row = replace(row, phase=phase)
        if row.kind == "prompt":
            question, acted = (row if row.name != PromptKind.INFORM.name.lower() else None), None
        elif row.kind == "marker" and row.name == TEACHER_ACTS:
            acted = row
        elif row.kind == "speech":
            spoken = row
        cause = None
        if _is_word(one):
            words[id(one)] = row
            if row.topic.rpartition("/")[2] in ANSWERS:
                cause = question
                if question is not None and acted is not None:
                    row = _parted(row, question, acted)
            elif spoken is not None and _SPOKEN.get(spoken.name) == row.name:
                cause, spoken = spoken, None
                row = replace(row, wizard_latency_s=row.time_s - cause.time_s)
        elif row.kind == "reply" and word is not None:
            cause = words.get(id(word))
        if cause is not None:
            row = replace(row, cause=cause.event, latency_s=row.time_s - cause.time_s)
        rows.append(row)
    return tuple(rows)


def _parted(answer: EventRow, question: EventRow, acted: EventRow) -> EventRow:
    """An answer with the time until the teacher acted, and from then until the operator entered it."""
    teacher, wizard = acted.time_s - question.time_s, answer.time_s - acted.time_s
    return replace(answer, teacher_latency_s=teacher, wizard_latency_s=wizard)


def _received(topic: str, message: BagMessage, decoded: Any) -> _Received:
    header = getattr(decoded, "header", None)
    stamp = 0 if header is None else int(header.stamp.sec) * 10**9 + int(header.stamp.nanosec)
    return _Received(topic, stamp, message.log_time, decoded)


def _is_word(one: _Received) -> bool:
    return one.topic.startswith("wizard/")


def _causal(received: Sequence[_Received]) -> Iterator[tuple[_Received, _Received | None]]:
    """Each message once, a reply with the word it answers (None: not in the bag) and never before it.

    A reply has the stamp of its word; a word without a stamp is answered in turn, by the next reply on its topic.
    """
    open_words: dict[str, list[_Received]] = {}
    for one in received:
        if _is_word(one):
            open_words.setdefault(one.topic, []).append(one)
    given: set[int] = set()
    for one in received:
        if id(one) in given:
            continue
        if one.topic != REPLY:
            given.add(id(one))
            yield one, None
            continue
        waiting = open_words.get(str(one.message.topic), [])
        same = [w for w in waiting if w.stamp and w.stamp == one.stamp]
        loose = [w for w in waiting if not w.stamp and w.time <= one.time + _SOON]
        word = next(iter(same or loose), None)
        if word is not None:
            waiting.remove(word)
            if id(word) not in given:
                given.add(id(word))
                yield word, None
        yield one, word


def _constant(message: Any, field: str) -> str:
    """The name that a message's definition gives a field's value, in small letters; the value where it gives none."""
    value = getattr(message, field)
    names = (n for n in dir(message) if n.isupper() and not n.startswith("_"))
    return next((n.lower() for n in names if getattr(message, n) == value), str(value))


def _name(code: int, kinds: type[Phase] | type[PromptKind]) -> str:
    """The name of a code; the code itself where a newer version knows more."""
    return kinds(code).name.lower() if code in set(kinds) else str(code)


def _row(one: _Received, session: str, number: int, time_s: float) -> EventRow:
    """The row of a message by itself."""
    message, topic = one.message, one.topic
    row = EventRow(session, number, time_s, "", _KINDS.get(topic, ""), topic, "", None, "", "", "", None, None, None)
    if topic == PROMPT:
        return replace(
            row,
            name=_name(int(message.kind), PromptKind),
            step=int(message.step_index) if message.step_index >= 0 else None,
            source=str(message.source_id),
            target=" ".join(getattr(message, "target_ids", ())),
            text=str(message.text),
        )
    if topic == REPLY:
        name = "accepted" if message.accepted else "refused"
        return replace(
            row, topic=str(message.topic), name=name, text=str(message.reason), accepted=bool(message.accepted)
        )
    if topic == STATE:
        return replace(row, name=_name(int(message.phase), Phase), text=str(message.detail))
    if topic == ESTIMATE:
        confident = bool(getattr(message, "confident", False))
        return replace(row, name="confident" if confident else "not_sure", text=f"{float(message.confidence):.6g}")
    if topic.endswith(_SERVICE):
        kind = _constant(message.info, "event_type") if hasattr(message, "info") else ""
        return replace(row, kind="service", name=kind)
    if topic == FORM:
        name = "declined" if message.declined else "sent"
        return replace(row, name=name, text=f"{message.form} {message.version}".strip())
    marker = str(getattr(message, "marker", ""))
    if topic == "wizard/note" and marker:
        return replace(row, kind="marker", name=marker, text=str(message.text))
    choice = next((_constant(message, f) for f in _CHOICES if hasattr(message, f)), topic.rpartition("/")[2])
    return replace(
        row,
        kind=row.kind or ("note" if topic == "wizard/note" else "word"),
        name=choice,
        step=next((int(getattr(message, f)) for f in ("step_index", "step") if hasattr(message, f)), None),
        target=next((str(getattr(message, f)) for f in _OBJECTS if hasattr(message, f)), ""),
        text=next((str(getattr(message, f)) for f in ("text", "reason") if hasattr(message, f)), ""),
    )
