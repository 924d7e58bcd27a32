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
from mbd_study.tables.forms import FormRow, ScoreRow
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


def answered(row: FormRow, item: str, kind: str, value: str, number: float | None) -> FormRow:
    return replace(row, item=item, kind=kind, question=f"{item}?", value=value, shown=f"»{value}«", number=number)


def test_forms_are_tables_of_the_phenotype_folder_valid_and_without_free_text(session: SessionTables, tmp_path: Path):
    head = FormRow("s", "nasa_tlx", 0, False, "1", "de", 10.0, 40.5, "done", False, "", "", "", True, "", "", None)
    last = replace(head, filling=1)
    rows_of = (
        answered(replace(head, superseded=True), "effort", "scale", "95", 95.0),
        answered(last, "effort", "scale", "5", 5.0),
        answered(last, "again", "yes_no", "yes", 1.0),
        answered(last, "session_id", "text", "my\tname is Zoë", None),
        replace(head, form="con-sent", filling=2, declined=True, answered=False),
    )
    scores = (ScoreRow("s", "nasa_tlx", 0, True, "raw", 95.0), ScoreRow("s", "nasa_tlx", 1, False, "raw", 5.0))
    plain = replace(session, sessions=(replace(session.sessions[0], session="later", start_unix_s=9e9),))
    made = [replace(session, forms=rows_of, scores=scores), plain]
    for notes in (False, True):
        out = tmp_path / f"bids{notes}"
        write_bids(out, made, DatasetFacts("any", ("A",), "CC0", notes), "1")
        (row,) = rows(out / "phenotype" / "nasatlx.tsv")
        assert (row["participant_id"], row["session_id"], row["form_seconds"]) == ("sub-simulated", "ses-01", "30.5")
        assert (row["effort"], row["again"], row["score_raw"]) == ("5.0", "yes", "5.0")
        assert row["session_id_2"] == ("my name is Zoë" if notes else "n/a")
        about = json.loads((out / "phenotype" / "nasatlx.json").read_text(encoding="utf-8"))
        assert set(about) == set(row)
        assert about["again"]["Levels"] == {"yes": "»yes«"}
        assert rows(out / "phenotype" / "consent.tsv")[0]["form_declined"] == "true"
        assert errors(out) == []
    assert "Zoë" not in "".join(f.read_text(encoding="utf-8") for f in (tmp_path / "bidsFalse").rglob("*.*sv"))
    again = replace(made[0], sessions=plain.sessions)
    write_bids(tmp_path / "twice", [made[0], again], DatasetFacts("any", ("A", "B"), "CC0"), "1")
    assert {f.stem for f in (tmp_path / "twice" / "phenotype").glob("nasatlx*.tsv")} == {
        "nasatlx_ses-01",
        "nasatlx_ses-02",
    }
    assert errors(tmp_path / "twice") == []
    write_bids(tmp_path / "none", [session], DatasetFacts("any"), "1")
    assert not (tmp_path / "none" / "phenotype").exists()


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
