"""Forms that participants sent in, an answer a row and a score a row."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isnan
from typing import Any

from mbd_bag.storage.bag import Bag
from mbd_model.session import Phase
from mbd_model.times import to_seconds

_TYPE = "mbd_msgs/msg/FilledForm"
# As FormAnswer.msg numbers them; a number that a newer version knows stays a number.
_KINDS = {1: "text", 2: "choice", 3: "scale", 4: "number", 5: "yes_no", 6: "agree"}


@dataclass(frozen=True)
class FormRow:
    """One answer; of a declined form one row without an item. `data_dictionary` states what each column holds."""

    session: str
    form: str
    filling: int
    superseded: bool
    version: str
    language: str
    opened_s: float | None
    sent_s: float
    phase: str
    declined: bool
    item: str
    kind: str
    question: str
    answered: bool
    value: str
    shown: str
    number: float | None


@dataclass(frozen=True)
class ScoreRow:
    """One score of a form that was sent in."""

    session: str
    form: str
    filling: int
    superseded: bool
    score: str
    value: float


def form_rows(bag: Bag, session: str) -> tuple[tuple[FormRow, ...], tuple[ScoreRow, ...]]:
    """The answers and scores of all forms in a bag, in the order in which they were sent in.

    Args:
        bag: of the session.
        session: its name.

    Raises:
        BagError: a message cannot be decoded.
    """
    topics = {t.name for t in bag.topics if t.msgtype == _TYPE and t.count}
    sent = [(m.log_time, decoded) for m, decoded in bag.decoded(topics)] if topics else []
    rows: list[FormRow] = []
    scores: list[ScoreRow] = []
    for number, (time, form) in enumerate(sent):
        again = any(str(later.form) == str(form.form) for _, later in sent[number + 1 :])
        head = _empty(session, number, form, to_seconds(time - bag.start))
        head = replace(head, superseded=again)
        rows += [_answer(head, answer) for answer in form.answers] or [head]
        scores += [ScoreRow(session, head.form, number, again, str(s.name), float(s.value)) for s in form.scores]
    return tuple(rows), tuple(scores)


def _empty(session: str, number: int, form: Any, sent_s: float) -> FormRow:
    """A form's row without an answer; when it was opened is counted back from when it was sent in, as clocks differ."""
    opened, stamp = (int(t.sec) * 10**9 + int(t.nanosec) for t in (form.opened, form.header.stamp))
    phase = int(form.phase)
    return FormRow(
        session=session,
        form=str(form.form),
        filling=number,
        superseded=False,
        version=str(form.version),
        language=str(form.language),
        opened_s=sent_s - to_seconds(max(0, stamp - opened)) if opened and stamp else None,
        sent_s=sent_s,
        phase=Phase(phase).name.lower() if phase in set(Phase) else "",
        declined=bool(form.declined),
        item="",
        kind="",
        question="",
        answered=False,
        value="",
        shown="",
        number=None,
    )


def _answer(head: FormRow, answer: Any) -> FormRow:
    number, kind = float(answer.number), int(answer.kind)
    return replace(
        head,
        item=str(answer.item),
        kind=_KINDS.get(kind, str(kind)),
        question=str(answer.text),
        answered=bool(answer.answered),
        value=str(answer.value),
        shown=str(answer.shown),
        number=number if answer.answered and not isnan(number) else None,
    )
