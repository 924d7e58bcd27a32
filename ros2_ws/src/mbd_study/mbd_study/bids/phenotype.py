"""What participants answered in forms, as BIDS keeps it: a table for each form, a row for each participant.

A form that somebody filled in in several sessions has a table for each of these, as no table may name one twice.

References:
    https://bids-specification.readthedocs.io, version 1.10: phenotypic and assessment data.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

from mbd_study.bids.labels import labels
from mbd_study.bids.rows import Cells
from mbd_study.tables.forms import FormRow, ScoreRow
from mbd_study.tables.table_rows import SessionTables

_TEXT = "text"
_NAMED = ("choice", "yes_no", "agree")  # kinds of items whose answers are names with words
_ABOUT = {
    "participant_id": "who filled the form in",
    "session_id": "the session in which it was filled in",
    "form_version": "of the form's text",
    "form_language": "in which it was shown (ISO 639-1)",
    "form_phase": "phase of the session when it was sent in",
    "form_declined": "whether nothing wanted to be answered, or the consent was not given",
    "form_seconds": "from when it was shown first until it was sent in [s]",
}


@dataclass(frozen=True)
class FormTable:
    """The answers to one form.

    Attributes:
        label: of its files.
        rows: as BIDS wants them, all of the same columns.
        columns: what each column holds, as its sidecar states it.
    """

    label: str
    rows: tuple[Cells, ...]
    columns: dict[str, dict[str, Any]]


def form_tables(sessions: Sequence[tuple[str, str, SessionTables]], *, texts: bool) -> tuple[FormTable, ...]:
    """The forms of a study, in the order of their names; what was sent in again counts as it was the last time.

    Args:
        sessions: (participant_id, session_id, tables) each.
        texts: keep what participants wrote in their own words.
    """
    people: dict[str, list[str]] = {}
    times: dict[str, set[str]] = {}
    for participant, session, tables in sessions:
        for name in sorted({row.form for row in tables.forms}):
            people.setdefault(name, []).append(participant)
            times.setdefault(name, set()).add(session)
    found = []
    for name, label in labels(sorted(people), "form").items():
        if len(people[name]) == len(set(people[name])):
            found.append(_table(name, label, sessions, texts))
            continue
        for time in sorted(times[name]):
            then = [one for one in sessions if one[1] == time]
            found.append(_table(name, f"{label}_{time}", then, texts))
    return tuple(found)


def _table(name: str, label: str, sessions: Sequence[tuple[str, str, SessionTables]], texts: bool) -> FormTable:
    def of_form(rows: Iterable[Any]) -> list[Any]:
        return [row for row in rows if row.form == name and not row.superseded]

    answers: list[FormRow] = of_form(row for *_, tables in sessions for row in tables.forms)
    scores: list[ScoreRow] = of_form(row for *_, tables in sessions for row in tables.scores)
    # An item, or a score, may be called as anything else is.
    items = labels_beside(dict.fromkeys(row.item for row in answers if row.item), (*_ABOUT,))
    sums = labels_beside(dict.fromkeys(f"score_{row.score}" for row in scores), (*_ABOUT, *items.values()))
    columns = {about: {"Description": words} for about, words in _ABOUT.items()}
    columns["form_seconds"]["Units"] = "s"
    columns |= {column: _described(item, answers, texts) for item, column in items.items()}
    columns |= {column: {"Description": f"{score[6:]}: by the form's rule"} for score, column in sums.items()}
    rows: list[Cells] = []
    for participant, session, tables in sessions:
        given = {f"score_{row.score}": row.value for row in of_form(tables.scores)}
        for _, same in groupby(of_form(tables.forms), key=lambda row: row.filling):
            filled = list(same)
            row: dict[str, Any] = {"participant_id": participant, "session_id": session, **_about(filled[0])}
            values = {one.item: _value(one, texts) for one in filled}
            row |= {column: values.get(item) for item, column in items.items()}
            rows.append(row | {column: given.get(score) for score, column in sums.items()})
    return FormTable(label, tuple(rows), columns)


def labels_beside(names: Iterable[str], taken: Iterable[str]) -> dict[str, str]:
    """A column for each name: itself, without what would break a table, and with a number where it is taken."""
    found: dict[str, str] = {}
    used = {name.lower() for name in taken}
    for name in names:
        plain = "_".join(name.split()) or "item"
        column, number = plain, 1
        while column.lower() in used:
            number += 1
            column = f"{plain}_{number}"
        used.add(column.lower())
        found[name] = column
    return found


def _about(row: FormRow) -> Cells:
    return {
        "form_version": row.version,
        "form_language": row.language,
        "form_phase": row.phase,
        "form_declined": row.declined,
        "form_seconds": None if row.opened_s is None else round(row.sent_s - row.opened_s, 3),
    }


def _value(row: FormRow, texts: bool) -> object:
    """An answer: the number of a scale, the name of an option; None where it is open, or in one's own words."""
    if not row.answered or (row.kind == _TEXT and not texts):
        return None
    return row.number if row.number is not None and row.kind not in _NAMED else row.value


def _described(item: str, answers: Sequence[FormRow], texts: bool) -> dict[str, Any]:
    """What a column holds: the question in each language it was shown in, and the words of its named answers."""
    same = [row for row in answers if row.item == item]
    words = " / ".join(dict.fromkeys(row.question for row in same))
    found: dict[str, Any] = {"Description": words or item}
    if any(row.kind == _TEXT for row in same) and not texts:
        found["Description"] += " (answers in one's own words are left out)"
    shown = {row.value: row.shown for row in same if row.answered and row.kind in _NAMED and row.value}
    if shown:
        found["Levels"] = shown
    return found
