"""The folder: what the standard wants of a behavioural data set, file by file.

References:
    Gorgolewski, K. J. et al. (2016): The brain imaging data structure. Scientific Data 3, 160044.
    https://bids-specification.readthedocs.io, version 1.10: behavioural experiments.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mbd_model.errors import MbdError

from mbd_study.bids.labels import labels
from mbd_study.bids.phenotype import form_tables
from mbd_study.bids.rows import Cells, cell_text, columns_of, estimate_cells, event_cells
from mbd_study.tables.table_rows import SessionTables

VERSION = "1.10.0"
HUMAN, NO_SPECIES = "homo sapiens", "n/a"
_README = """# {name}

Sessions of Mapping by Demonstration: a person shows a task once, and gives assists until the robot knows which object
of the new scene plays which role. Written by `mbd_study bids` from recorded bags.

- `sub-*/ses-*/beh/*_events.tsv`: all that happened in a session: questions, answers, refusals, phases, estimates.
- `sub-*/ses-*/beh/*_beh.tsv`: a row for each estimate of the object mapping.
- `sub-*/sub-*_sessions.tsv`: the sessions of a participant, in the order in which they were held.
- `phenotype/*.tsv`: what participants answered in forms, where they did; `session_id` says in which session.

Times count from the beginning of each session; no date is given. {notes} Trajectories and pictures are not here; the
bags hold them. {simulated}
"""


class BidsError(MbdError):
    """A data set that cannot be written."""


@dataclass(frozen=True)
class DatasetFacts:
    """What a study states of itself.

    Attributes:
        name: of the data set.
        authors: names, as they shall be cited.
        licence: of the data, "" where none is stated.
        notes: the text of the operator's notes, and what participants wrote in forms, is kept.
    """

    name: str
    authors: tuple[str, ...] = ()
    licence: str = ""
    notes: bool = False


def write_bids(folder: Path, sessions: Sequence[SessionTables], facts: DatasetFacts, version: str) -> None:
    """Write a data set.

    Args:
        folder: of it; it must not exist.
        sessions: tables of each.
        facts: of the study.
        version: of this software.

    Raises:
        BidsError: the folder exists, or there is no session.
    """
    if folder.exists():
        raise BidsError(f"{folder} exists already and is not overwritten; choose another --out")
    if not sessions:
        raise BidsError("there is no session to write; give bags, or folders of bags")
    ordered = sorted(sessions, key=lambda s: s.sessions[0].start_unix_s)
    people = labels((_participant(s) for s in ordered), "anonymous")
    tasks = labels((s.sessions[0].task for s in ordered), "unknown")
    folder.mkdir(parents=True)
    _write_about(folder, ordered, people, facts, version)
    counts: dict[str, int] = {}
    held: dict[str, list[Cells]] = {}
    named: list[tuple[str, str, SessionTables]] = []
    for one in ordered:
        row = one.sessions[0]
        subject = f"sub-{people[_participant(one)]}"
        counts[subject] = counts.get(subject, 0) + 1
        session = f"ses-{counts[subject]:02d}"
        held.setdefault(subject, []).append(_session_cells(session, one))
        named.append((subject, session, one))
        beh = folder / subject / session / "beh"
        beh.mkdir(parents=True)
        stem = f"{subject}_{session}_task-{tasks[row.task]}"
        _write_tsv(beh / f"{stem}_events.tsv", event_cells(one.events, row.duration_s, notes=facts.notes), "events")
        _write_tsv(beh / f"{stem}_beh.tsv", estimate_cells(one.estimates), "estimates")
    for subject, cells in held.items():
        _write_tsv(folder / subject / f"{subject}_sessions.tsv", cells)
    _write_forms(folder, named, texts=facts.notes)
    for task, label in tasks.items():
        about = {"TaskName": task or "unknown", "TaskDescription": f"{task}, shown to a robot by demonstration"}
        _write_json(folder / f"task-{label}_events.json", about | columns_of("events"))
        _write_json(folder / f"task-{label}_beh.json", about | columns_of("estimates"))


def _write_forms(folder: Path, sessions: Sequence[tuple[str, str, SessionTables]], *, texts: bool) -> None:
    """A table for each form that somebody sent in; no folder where nobody did."""
    for form in form_tables(sessions, texts=texts):
        place = folder / "phenotype"
        place.mkdir(exist_ok=True)
        _write_tsv(place / f"{form.label}.tsv", form.rows)
        _write_json(place / f"{form.label}.json", form.columns)


def _participant(one: SessionTables) -> str:
    """The participant; of none that is named every session counts as another person's."""
    return one.sessions[0].participant or one.sessions[0].session


def _session_cells(session: str, one: SessionTables) -> Cells:
    row = one.sessions[0]
    return {
        "session_id": session,
        "session": row.session,
        "task": row.task,
        "condition": row.condition,
        "seed": row.seed,
        "duration_s": round(row.duration_s, 3),
        "last_phase": row.last_phase,
        "assists": row.assists,
        "correct": row.correct,
    }


_SESSION_COLUMNS = {
    "session": "name of the recorded session",
    "task": "name of the task",
    "condition": "of the study's plan",
    "seed": "of the simulated cell; n/a for a person",
    "duration_s": "from the first to the last message [s]",
    "last_phase": "in which the session ended",
    "assists": "number of assists in force at the end",
    "correct": "whether the last estimate is right, by the simulated cell's truth; n/a for people",
}


def _write_about(
    folder: Path, sessions: Sequence[SessionTables], people: Mapping[str, str], facts: DatasetFacts, version: str
) -> None:
    about: dict[str, Any] = {"Name": facts.name, "BIDSVersion": VERSION, "DatasetType": "raw"}
    if facts.licence:
        about["License"] = facts.licence
    if facts.authors:
        about["Authors"] = list(facts.authors)
    about["GeneratedBy"] = [{"Name": "mbd_study", "Version": version}]
    _write_json(folder / "dataset_description.json", about)
    simulated = sum(bool(s.sessions[0].seed) for s in sessions)
    words = {
        "name": facts.name,
        "notes": f"What was noted, or written in forms, is {'kept' if facts.notes else 'left out'}.",
        "simulated": f"{simulated} of {len(sessions)} sessions are SIMULATED." if simulated else "",
    }
    (folder / "README.md").write_text(_README.format(**words), encoding="utf-8")
    by_person: dict[str, set[bool]] = {}
    for one in sessions:
        by_person.setdefault(_participant(one), set()).add(bool(one.sessions[0].seed))
    rows = [
        {"participant_id": f"sub-{label}", "species": NO_SPECIES if by_person[name] == {True} else HUMAN}
        for name, label in people.items()
    ]
    _write_tsv(folder / "participants.tsv", rows)
    words = {"species": "homo sapiens, or n/a where a program took the participant's place in every session"}
    _write_json(folder / "participants.json", {k: {"Description": v} for k, v in words.items()})
    _write_json(folder / "sessions.json", {k: {"Description": v} for k, v in _SESSION_COLUMNS.items()})


def _write_json(path: Path, value: Any) -> None:
    path.write_text(json.dumps(value, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")


def _write_tsv(path: Path, rows: Sequence[Cells], table: str = "") -> None:
    """A table; one without rows has the columns of its sidecar."""
    names = list(rows[0]) if rows else list(columns_of(table))
    lines = ["\t".join(names), *("\t".join(cell_text(row[name]) for name in names) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
