"""A BIDS folder is valid by the standard's own validator, and holds each session once without what was noted."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mbd_bag.session.command_line import open_session
from mbd_study.bids import bids_command
from mbd_study.bids.bids_folder import BidsError, DatasetFacts, write_bids
from mbd_study.bids.labels import labels
from mbd_study.bids.rows import cell_text, event_cells
from mbd_study.tables.table_rows import SessionTables, session_tables

BAGS = Path(__file__).resolve().parents[2] / "bags"
VALIDATOR = Path(sys.executable).parent / "bids-validator-deno"


def run(monkeypatch: pytest.MonkeyPatch, *words: str) -> int:
    monkeypatch.setattr(sys, "argv", ["bids", *words])
    with pytest.raises(SystemExit) as ended:
        bids_command.main()
    return int(ended.value.code)


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream, delimiter="\t", quoting=csv.QUOTE_NONE))


def errors(folder: Path) -> list[Any]:
    """What the validator refuses; it asks for no network."""
    if not VALIDATOR.exists():
        pytest.skip("bids-validator-deno is not installed (requirements/test.txt)")
    words = [str(VALIDATOR), "--format", "json", "--max-rows", "-1", str(folder)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    issues = json.loads(done.stdout)["issues"]["issues"]
    return [i for i in issues if i["severity"] == "error" or i["code"] == "TSV_ADDITIONAL_COLUMNS_UNDEFINED"]


@pytest.fixture(scope="module")
def session() -> SessionTables:
    return session_tables(*open_session(BAGS / "stacking_undo"))


def test_a_folder_of_sessions_is_valid_and_a_planted_mistake_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    out = tmp_path / "bids"
    bags = [str(BAGS / name) for name in ("stacking_undo", "sorting")]
    assert run(monkeypatch, *bags, "--out", str(out), "--jobs", "1", "--licence", "CC0", "--author", "A") == 0
    assert errors(out) == []
    assert {r["session"] for r in rows(next(out.glob("sub-*/sub-*_sessions.tsv")))} == {"sorting", "stacking_undo"}
    assert len(list(out.glob("sub-*/ses-*/beh/*_events.tsv"))) == 2
    (out / "sub-simulated" / "ses-01" / "beh" / "sub-simulated_task-x_joy.tsv").write_text("a\n1\n")
    assert errors(out) != []
    assert run(monkeypatch, *bags, "--out", str(out)) == 2


def test_people_and_tasks_with_awkward_names_give_a_valid_folder_and_no_two_the_same_place(
    session: SessionTables, tmp_path: Path
):
    row = session.sessions[0]
    people = ("p-1", "p1", "P_1", "", "Zoë\tB")
    made = [
        replace(session, sessions=(replace(row, participant=p, task=t, session=f"{k}{t}", start_unix_s=float(k)),))
        for k, p in enumerate(people)
        for t in ("dish sorting", "dish_sorting", "")
    ]
    write_bids(tmp_path / "bids", made, DatasetFacts("any", ("A", "B"), "CC0"), "1")
    # Nobody knows whether two sessions without a pseudonym are of one person.
    assert len(list((tmp_path / "bids").glob("sub-*"))) == 4 + 3
    assert len(list((tmp_path / "bids").glob("sub-*/ses-*/beh/*_events.tsv"))) == len(made)
    assert errors(tmp_path / "bids") == []


def test_what_was_noted_is_left_out_unless_asked_for_and_events_are_in_order(session: SessionTables):
    (note,) = (e for e in session.events if e.kind == "note")
    without = event_cells(session.events, 70.0, notes=False)
    kept = event_cells(session.events, 70.0, notes=True)
    assert note.text not in {r["text"] for r in without if r["trial_type"] == "note"}
    assert note.text in {r["text"] for r in kept}
    assert [r["onset"] for r in kept] == sorted(r["onset"] for r in kept)
    assert len(kept) == len(session.events)
    phases = [r for r in kept if r["trial_type"] == "phase"]
    assert sum(r["duration"] for r in phases) == pytest.approx(70.0 - phases[0]["onset"], abs=1e-3)


@given(st.lists(st.text(max_size=8), max_size=12))
def test_labels_are_letters_and_digits_and_tell_names_apart(names: list[str]):
    found = labels(names, "nobody")
    assert set(found) == set(names)
    assert all(label.isascii() and label.isalnum() for label in found.values())
    assert len({label.lower() for label in found.values()}) == len(found)


@given(st.none() | st.booleans() | st.floats() | st.text())
def test_no_cell_breaks_its_row(value: object):
    text = cell_text(value)
    assert text
    assert len(text.splitlines()) == 1
    assert "\t" not in text


def test_nothing_is_written_over_and_no_session_is_no_data_set(session: SessionTables, tmp_path: Path):
    with pytest.raises(BidsError, match="not overwritten"):
        write_bids(tmp_path, [session], DatasetFacts("any"), "1")
    with pytest.raises(BidsError, match="no session"):
        write_bids(tmp_path / "new", [], DatasetFacts("any"), "1")
    assert not (tmp_path / "new").exists()
