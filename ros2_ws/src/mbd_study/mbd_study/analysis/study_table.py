"""A table of sessions as measures: from what `export` wrote, or any CSV table with a row for each session."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from mbd_model.parameters import nearest

from mbd_study.analysis.measured import AnalysisError, MeasuredValue, MeasuredValues, MeasureScale, scale_of

MEASURES = ("correct", "assists", "confidence", "duration_s", "refused_events", "answer_latency_s")
_ANSWERS = frozenset({"wizard/handed", "wizard/pointed", "wizard/answer"})
_TRUTHS = {"true": 1.0, "false": 0.0}
TextRow = Mapping[str, str]


@dataclass(frozen=True)
class StudyTable:
    """Sessions, a row each, and what was left out of them.

    Attributes:
        rows: cells by column, as text.
        left_out: sentences.
        exported: `export` wrote it.
        scores: columns that are scores of forms.
    """

    rows: tuple[TextRow, ...]
    left_out: tuple[str, ...] = ()
    exported: bool = False
    scores: frozenset[str] = frozenset()

    @property
    def columns(self) -> tuple[str, ...]:
        """Names, in order."""
        return tuple(self.rows[0]) if self.rows else ()

    @property
    def simulated(self) -> int:
        """How many sessions have a seed of the simulated cell."""
        return sum(bool(row.get("seed")) for row in self.rows) if self.exported else 0


def read_csv(path: Path, *, empty: bool = False) -> tuple[TextRow, ...]:
    """A CSV table.

    Args:
        path: of the file, UTF-8, the first line with the columns' names.
        empty: it may have no rows.

    Raises:
        AnalysisError: it cannot be read, or is no such table.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as stream:
            reader = csv.DictReader(stream, strict=True)
            rows = list(reader)
    except OSError as error:
        raise AnalysisError(f"{path} cannot be read: {error.strerror}; give a CSV file, or export's folder") from error
    except (csv.Error, UnicodeDecodeError) as error:
        raise AnalysisError(f"{path} is no CSV table in UTF-8: {error}; expected what `export` writes") from error
    if not rows and not empty:
        raise AnalysisError(f"{path} has no rows; expected one for each session below the columns' names")
    for number, row in enumerate(rows):
        if None in row or None in row.values():
            raise AnalysisError(f"{path} line {number + 2} has not as many cells as the first line has names")
    return tuple(rows)


def read_study(path: Path, conditions: Mapping[str, str] | None = None) -> StudyTable:
    """The sessions of a CSV table, or of the folder that `export` wrote; unfinished ones and first tries left out.

    Args:
        path: of the file or folder.
        conditions: by session, from the plan.

    Raises:
        AnalysisError: it cannot be used, or no session is left.
    """
    exported = path.is_dir()
    if exported and not (path / "sessions.csv").is_file():
        raise AnalysisError(f"{path} has no sessions.csv; give the folder that `export` wrote, or a CSV file")
    rows = read_csv(path / "sessions.csv" if exported else path)
    left_out = []
    if exported:
        first_tries = [r["session"] for r in rows if r.get("superseded") == "true"]
        unfinished = [r["session"] for r in rows if r.get("last_phase") != "done" and r.get("superseded") != "true"]
        for names, why in ((first_tries, "first tries"), (unfinished, "not finished")):
            if names:
                left_out.append(f"{len(names)} of {len(rows)} sessions are left out, {why}: {', '.join(names)}")
        gone = set(unfinished)
        rows = tuple(r for r in rows if r.get("superseded") != "true" and r["session"] not in gone)
        rows = _with_latencies(rows, path / "events.csv")
        rows = _with_answers(rows, path)
    if conditions is not None:
        if rows and "session" not in rows[0]:
            raise AnalysisError(f"{path} has no column 'session' by which a plan knows its sessions; give --by COLUMN")
        unknown = [r.get("session", "") for r in rows if r.get("session", "") not in conditions]
        if unknown:
            left_out.append(f"{len(unknown)} sessions are left out, not in the plan: {', '.join(unknown)}")
        rows = tuple({**r, "condition": conditions[r["session"]]} for r in rows if r.get("session", "") in conditions)
    if not rows:
        raise AnalysisError(f"{path} has no session that can be compared: {'; '.join(left_out)}")
    return StudyTable(rows, tuple(left_out), exported, _scores(path / "scores.csv"))


def _with_latencies(rows: tuple[TextRow, ...], events: Path) -> tuple[TextRow, ...]:
    """Sessions with the median time from a question to its answer, where there are events."""
    if not events.is_file():
        return rows
    found: dict[str, list[float]] = {}
    for event in read_csv(events, empty=True):
        if event["topic"] in _ANSWERS and event["latency_s"]:
            found.setdefault(event["session"], []).append(float(event["latency_s"]))
    return tuple(
        {**r, "answer_latency_s": str(median(found[r["session"]])) if r["session"] in found else ""} for r in rows
    )


def _scores(path: Path) -> frozenset[str]:
    cells = read_csv(path, empty=True) if path.is_file() else ()
    return frozenset(f"form_{cell['form']}_{cell['score']}" for cell in cells)


def _with_answers(rows: tuple[TextRow, ...], folder: Path) -> tuple[TextRow, ...]:
    """Sessions with each score, and each answer that is a number, of the forms that count: form_<form>_<name>."""
    found: dict[str, dict[str, str]] = {}
    for file, name, value in (("scores.csv", "score", "value"), ("forms.csv", "item", "number")):
        if (folder / file).is_file():
            for cell in read_csv(folder / file, empty=True):
                if cell[value] and cell["superseded"] != "true":
                    column = f"form_{cell['form']}_{cell[name]}"
                    found.setdefault(column, {}).setdefault(cell["session"], cell[value])
    return tuple({**r, **{c: by_session.get(r["session"], "") for c, by_session in found.items()}} for r in rows)


def column_of(table: StudyTable, name: str) -> str:
    """A column's name; raises AnalysisError with the nearest where it is not there."""
    if name in table.columns:
        return name
    near = nearest(name, table.columns)
    hint = f"did you mean {near!r}?" if near else f"there are {', '.join(table.columns)}"
    raise AnalysisError(f"the table has no column {name!r}; {hint}")


def measured_values(
    table: StudyTable,
    measure: str,
    *,
    by: str,
    participant: str,
    block: str = "",
    scale: MeasureScale | None = None,
) -> MeasuredValues | None:
    """A column as a measure; None where it is empty throughout.

    Args:
        table: of the sessions.
        measure: column of the values: numbers, or true and false; empty cells are left out.
        by: column of the conditions.
        participant: column of the participants.
        block: column of the blocks; "" for none.
        scale: of the numbers, where it is not as it looks.

    Raises:
        AnalysisError: a column is not there, a cell is no number, or a session states no participant.
    """
    for name in (measure, by, participant, *([block] if block else [])):
        column_of(table, name)
    values, truths = [], True
    for number, row in enumerate(table.rows):
        if row[measure].strip() == "" or row[by] == "":
            continue
        if not row[participant]:
            raise AnalysisError(
                f"row {number + 1} has no {participant}; without it nobody knows which values are of one"
            )
        text = row[measure].strip().lower()
        truths = truths and text in _TRUTHS
        values.append(
            MeasuredValue(row[participant], row[by], _number(text, measure, number), row[block] if block else "")
        )
    if not values:
        return None
    return MeasuredValues(measure, scale or scale_of([v.value for v in values], truths=truths), tuple(values))


def _number(text: str, column: str, row: int) -> float:
    try:
        value = _TRUTHS[text] if text in _TRUTHS else float(text)
    except ValueError:
        raise AnalysisError(
            f"column {column!r}, row {row + 1} is {text!r}; expected a number, or true or false"
        ) from None
    if value - value != 0:
        raise AnalysisError(f"column {column!r}, row {row + 1} is {text!r}; expected a finite number, or an empty cell")
    return value


def usual_measures(table: StudyTable) -> tuple[str, ...]:
    """What is compared where nobody says what: of exported tables what studies ask for, as far as it varies.

    Raises:
        AnalysisError: the table is not `export`'s.
    """
    if not table.exported:
        raise AnalysisError(
            f"say which columns are the measures: --measures NAME...; there are {', '.join(table.columns)}"
        )
    scores = [name for name in table.columns if name.startswith("form_") and name in table.scores]
    return tuple(m for m in (*MEASURES, *scores) if m in table.columns and len({r[m] for r in table.rows} - {""}) > 1)


def condition_column(table: StudyTable, given: Sequence[str | None]) -> str:
    """The column of the conditions: what was given, else one named condition.

    Args:
        table: of the sessions.
        given: a column's name or None, first come first served.

    Raises:
        AnalysisError: none is given, and there is none of that name.
    """
    for name in given:
        if name:
            return column_of(table, name)
    if len({row.get("condition", "") for row in table.rows} - {""}) > 1:
        return "condition"
    few = [c for c in table.columns if 1 < len({row[c] for row in table.rows} - {""}) <= 6]
    by = f"or --by one of {', '.join(few)}" if few else "as no column has 2 to 6 different values to go --by"
    raise AnalysisError(f"nothing says which sessions are of which condition; give --plan plan.yaml, {by}")
